"""Data that took no part in finding or fitting, and what the twin says of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from ddh_twin_py.gap.drive.direct_drive import STEP, DirectDrive
from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.shrink.size import counted
from ddh_twin_py.physics.thermal_network import TANK


@dataclass(frozen=True)
class HeldData:
    """Held-out data of a case: the validation recording, or the end of each field recording.

    Attributes:
        model: of the rig. words: which data these are.
    """

    model: DirectDrive
    words: str

    @staticmethod
    def of(model: DirectDrive) -> HeldData:
        """The validation recordings where there are any."""
        if model.held:
            names = ", ".join(e.recording.path for e in model.held)
            return HeldData(model, f"{names} (validation, the whole of it)")
        parts = [f"{e.recording.path} from {e.held_from:.0f} s to its end at {e.duration:.0f} s (the {e.held_from - e.used_until:.0f} s "
                 "before count nowhere)" for e in model.field]
        return HeldData(model, "; ".join(parts))

    def signals(self) -> list[Mapping]:
        """Signals by recording."""
        return [e.signals for e in (self.model.held or self.model.field)]

    def mask(self) -> Callable[[object], np.ndarray]:
        """Which samples of a signal count."""
        return counted if self.model.held else attrgetter("held_back")

    def open_begins(self) -> list[int]:
        """In how many ways each recording may begin otherwise than is likely; of a field recording that was fitted none."""
        return [e.open_begins for e in self.model.held] or [0] * len(self.model.field)

    def run(self, theta: np.ndarray, acting: Acting, begin: Sequence[Sequence[float]] | None = None,
            roughly: bool = False) -> list[dict[str, np.ndarray]]:
        """Free runs, by recording; ``begin`` as in `Experiment.predict`, by recording; None: all as their first minutes tell."""
        if self.model.held:
            begins = begin if begin is not None else [None] * len(self.model.held)
            return [held.predict(self.model.held_record(number, theta, acting), STEP, own_history=True, begin=own, roughly=roughly)
                    for number, (held, own) in enumerate(zip(self.model.held, begins, strict=True))]
        return [self.model.run_one(self.model.first + number, theta, acting, roughly) for number in range(len(self.model.field))]

    def axes(self, theta: np.ndarray, acting: Acting) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Variables on which residuals may depend, from the free run of the first recording."""
        model = self.model
        experiment = (model.held or model.field)[0]
        record = model.held_record(0, theta, acting) if model.held else model.record(model.first, theta, acting)
        points, temperatures = experiment.operating(record)
        return {
            "speed, rad/s": (experiment.axis, points["speed"]),
            "piston-side pressure, Pa": (experiment.axis, points["pressure_piston_side"]),
            "rod position, m": (experiment.axis, points["rod_position"]),
            "rod velocity, m/s": (experiment.axis, points["rod_velocity"]),
            "tank oil temperature, K": (experiment.axis, temperatures[:, TANK]),
        }
