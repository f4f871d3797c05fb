"""What the diagnosis asks of any rig's model: free runs of its recordings, data that take no part, what is known of the rig.

What finding a place asks beside them is in `locate.locatable`, all that a whole answer does in `diagnosable`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from ddh_twin_py.estimation.fitting.calibration import FittedParameter
from ddh_twin_py.gap.effect import Acting, Effect
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.gap.witnesses import Witnesses


class FreeRuns(Protocol):
    """Recordings and free runs of them.

    Attributes:
        signals: by recording, name to signal (``time`` s, ``measured``, ``noise``, ``unit``, ``binning``).
        altered: by recording, whether effects act in it; they do not in a commissioning recording.
        witnesses: signals that small flaws of the laws move far.
    """

    signals: Sequence[Mapping]
    altered: Sequence[bool]
    witnesses: Witnesses

    def run_one(self, number: int, theta: np.ndarray, acting: Acting = (), roughly: bool = False) -> dict[str, np.ndarray]:
        """Free run of one recording: signal to predictions at its samples; ``roughly`` where only its difference to another such run is
        asked."""
        ...


class Model(FreeRuns, Protocol):
    """A rig's model with its recordings.

    Attributes:
        size: number of parameters, k. difference: of a deviation, over which sensitivities to them are taken.
    """

    size: int
    difference: float

    def within(self, theta: np.ndarray) -> np.ndarray:
        """Deviations (k,) brought within what tolerances and laws allow."""
        ...

    def record(self, number: int, theta: np.ndarray, acting: Acting = ()) -> np.ndarray:
        """Parameter record (1,) of one recording, which effects change."""
        ...

    def run(self, theta: np.ndarray, acting: Acting = ()) -> list[dict[str, np.ndarray]]:
        """Free run of every recording: signal to predictions at its samples."""
        ...

    def begin_anew(self, theta: np.ndarray, acting: Acting) -> bool:
        """Let altered recordings begin as effects would have left the rig, where that is not measured; whether that changes much."""
        ...

    def variables(self, comparisons: Sequence, theta: np.ndarray, acting: Acting = ()) -> list[dict[str, np.ndarray]]:
        """On what a discrepancy may depend, for every bin, by recording: name to (rows,)."""
        ...


class Held(Protocol):
    """Data that took no part in finding or fitting.

    Attributes:
        words: which data these are.
    """

    words: str

    def signals(self) -> list[Mapping]:
        """Signals by recording."""
        ...

    def mask(self) -> Callable[[Any], np.ndarray]:
        """Which samples of a signal count."""
        ...

    def open_begins(self) -> list[int]:
        """By recording, in how many ways it may begin otherwise than is likely from what is read."""
        ...

    def run(self, theta: np.ndarray, acting: Acting, begin: Sequence[Sequence[float]] | None = None,
            roughly: bool = False) -> list[dict[str, np.ndarray]]:
        """Free runs, by recording.

        Args:
            begin: by recording, standard deviations of each of those ways; None: as the first minutes of each tell.
            roughly: where only the difference to another such run is asked.
        """
        ...

    def axes(self, theta: np.ndarray, acting: Acting) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Variables on which residuals may depend, name with unit to times and values."""
        ...


class DescribedModel(Model, Protocol):
    """A model with what is known of its rig beside free runs.

    Attributes:
        catalogue: effects by id. recordings: kind (``field``, ...) to names. assumptions: texts.
        variable_units: of what `variables` gives. followed: signals that a run of held-out data under the true cause follows to the
            floor where what is open of rig and begin is at its best; others sum up small flaws. kinematic: signals that follow a command
            or the geometry, in which no law of the rig errs by more than their noise.
        cut: standard deviations of its prior beyond which no parameter is fitted, infinite where nothing holds them.
        rig: its description as known before; has ``rig_id``, ``file``, ``quantities``.
    """

    catalogue: Mapping[str, Effect]
    recordings: Mapping[str, list[str]]
    assumptions: list[str]
    variable_units: Mapping[str, str]
    followed: Sequence[str]
    kinematic: Sequence[str]
    cut: float
    rig: Any

    def tolerances(self) -> Mapping[str, float | None]:
        """Standard deviation of every field of the record, None where none is given."""
        ...

    def held_data(self) -> Held:
        """What took no part."""
        ...

    def unknown_inputs(self, theta: np.ndarray, spread: np.ndarray) -> list[Lack]:
        """What the first recording in question asks for beyond the model at parameters (k,), by place; empty where nothing tells."""
        ...

    def learned_terms(self, component: str, domain: str) -> Sequence[Effect]:
        """Terms of the model that may be learned at a place; none where it has none."""
        ...

    def unlisted_laws(self) -> Sequence[Effect]:
        """Laws in no catalogue that listed effects together may be mistaken for; none where none is known."""
        ...

    def fitted_parameters(self, theta: np.ndarray, spread: np.ndarray) -> list[FittedParameter]:
        """Parameters with prior and posterior; both arguments in deviations, (k,)."""
        ...

    def rig_with(self, theta: np.ndarray, acting: Acting, spread: np.ndarray, *, joint: np.ndarray | None = None,
                 as_built: bool = False) -> Any:
        """The rig's description with fitted parameters and effects in it.

        Args:
            joint: their covariance, see `refit.Refitted`. as_built: whether recordings in which nothing acts alone told the parameters.
        """
        ...

    def notes(self) -> list[str]:
        """What these recordings cannot say, whatever was found."""
        ...
