"""What the answer to a case asks of the direct driven unit (`diagnosable.Diagnosable`)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from ddh_twin_py.estimation.fitting.calibration import INFORMED, FittedParameter
from ddh_twin_py.estimation.fitting.experiment import DRIVE_SIGNALS, HYDRAULIC_SIGNALS, Experiment
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.contract import NextTest
from ddh_twin_py.gap.drive.courses import course
from ddh_twin_py.gap.drive.direct_drive import STEP, DirectDrive
from ddh_twin_py.gap.drive.held_data import HeldData
from ddh_twin_py.gap.drive.inputs import unknown_inputs
from ddh_twin_py.gap.drive.learned_terms import terms, terms_at, unlisted_laws
from ddh_twin_py.gap.drive.next_test import next_test
from ddh_twin_py.gap.drive.next_test_of_unknown import next_test_of_unknown
from ddh_twin_py.gap.effect import Acting, Effect
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import Column, columns_of
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.explain.side_by_side import THREADS
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.gap.locate.free_places import FreePlace, free_places
from ddh_twin_py.gap.locate.lacking import Course
from ddh_twin_py.gap.locate.leftover import FreeForm
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.verdict import Verdict
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.payload import PAYLOAD, RATIO
from ddh_twin_py.rig.sheet import CUT, FIELD_OF_PATH
from ddh_twin_py.telemetry.recording import announced_id
from ddh_twin_py.telemetry.signals import DRIVE_FIELDS
from ddh_twin_py.twin.temperature_sensors import SENSORS

_FEW = 10  # quantities with a tolerance, below which a sheet is taken for exact
ASSUMPTIONS = [
    "The rig's parameters are independent and normal within the sheet's tolerances, and the same in all recordings.",
    "With a commissioning recording an effect acts since then; without one the rig is held against its rig file, or the reference sheet "
    "where none is given.",
    "Noise of the sensors is white and as the sheet says; a model's laws are a little wrong in every direction, those of the effects too.",
    "No more than two effects act at once.",
]


def reader_of(signal: str) -> str:
    """The component that reads a signal: what the drive tells, it measures itself."""
    return "drive" if signal in DRIVE_FIELDS else "sensor"


class DriveCase(DirectDrive):
    """Recordings of one unit with all that the answer asks; see `diagnosable.Diagnosable` and, for the arguments, `DirectDrive`."""

    catalogue = EFFECTS
    assumptions = ASSUMPTIONS
    variable_units: Mapping[str, str] = {"oil temperature": "K", "speed": "rad/s"}
    kinematic = ("speed", "rod_velocity")
    cut = CUT

    def __init__(self, commissioning: Sequence[Experiment], field: Sequence[Experiment], rig: Rig, held: Sequence[Experiment] = ()) -> None:
        recorded = announced_id(e.recording for e in field) or rig.rig_id
        super().__init__(commissioning, field, replace(rig, rig_id=recorded), held)
        another = rig.of_another(recorded)
        self.of_another = [f"{another}; what was fitted to another rig is no tolerance of this one"] if another else []
        kinds = {"field": field, "commissioning": commissioning, "validation": held}
        self.recordings = {kind: [e.recording.path for e in own] for kind, own in kinds.items() if own}

    @property
    def followed(self) -> tuple[str, ...]:
        """All but those that sum up small flaws; none of the end of a field recording whose begin is open."""
        signals = self.held_data().signals()
        if not self.held and any(e.open_begins for e in self.field):
            return ()
        return tuple(dict.fromkeys(name for own in signals for name in own if name not in self.witnesses.summing))

    def tolerances(self) -> dict[str, float | None]:
        """Of the sheet, by field of the record; zero errors of sensors have one too."""
        out: dict[str, float | None] = {}
        for path, field in FIELD_OF_PATH.items():
            std = self.rig.quantities[path].standard_deviation
            out[field] = std if std > 0.0 and (not path.startswith("measurement.") or path.endswith("_offset")) else None
        return out

    def held_data(self) -> HeldData:
        """The validation recordings, else the end of each field recording."""
        return HeldData.of(self)

    def free_places(self, found: Found, forms: list[FreeForm], off: str = "") -> list[FreePlace]:
        """Places by how much their free inputs explain, the likeliest first."""
        own = found.linearised
        with ThreadPoolExecutor(max_workers=THREADS) as pool:
            return self._free_places(own, columns_of(terms(), self, own.theta, own.comparisons, pool), off)

    def best_place(self, linearised: Linearised) -> FreePlace | None:
        """That whose listed effects explain most, free in every phase and with speed and warmth."""
        return next(iter(self._free_places(linearised)), None)

    def _free_places(self, own: Linearised, further: Sequence[Column] = (), off: str = "") -> list[FreePlace]:
        variables = self.variables(own.comparisons, own.theta)
        return free_places(own, [*own.columns, *further], variables, lambda signal: (reader_of(signal), "measurement"), off)

    def unknown_inputs(self, theta: np.ndarray, spread: np.ndarray) -> list[Lack]:
        """Torque, force, flow and heat left over in the first field recording, less those of the commissioning recording."""
        built = self.commissioning[0].recording if self.commissioning else None
        return unknown_inputs(self.field[0].recording, built, self.rig_with(theta, (), spread))

    def learned_terms(self, component: str, domain: str) -> Sequence[Effect]:
        """What no law of the model gives at a place, in the simplest forms that it may have; see `learned_terms.terms_at`."""
        return terms_at(component, domain)

    def unlisted_laws(self) -> Sequence[Effect]:
        """See `learned_terms.unlisted_laws`."""
        return unlisted_laws()

    def course(self, effect: Effect, without: np.ndarray, acting: np.ndarray) -> Course:
        """What an effect adds over the first field recording."""
        return course(effect, self.field[0], without, acting, STEP)

    def next_test(self, found: Found, verdict: Verdict, unknown: Unknown) -> NextTest | None:
        """The test that would tell most, None where nothing is left to tell apart."""
        if verdict.word == "no_gap":
            return None
        if verdict.word == "unknown" and unknown.forms:
            form = unknown.forms[0]
            return next_test_of_unknown(self, found, verdict.leader, form.signal, form.size, form.depends_on)
        return next_test(self, found)

    def fitted_parameters(self, theta: np.ndarray, spread: np.ndarray) -> list[FittedParameter]:
        """Parameters with prior and posterior; the payload as the ratio to what each recording declares."""
        out = []
        for path, deviation, std, scale in zip(self.paths, theta, spread, self.problem.scale, strict=False):  # begins are not the rig's
            q = self.rig.quantities[path]
            if path == PAYLOAD:
                path, scale, q = RATIO, scale / q.value * self.rig[RATIO], self.rig.quantities[RATIO]
            value = q.value + float(deviation * scale)
            out.append(FittedParameter(path, q.unit, q.value, float(scale), value, float(std * scale), bool(std < INFORMED)))
        return out

    def rig_with(self, theta: np.ndarray, acting: Acting, spread: np.ndarray, *, joint: np.ndarray | None = None,
                 as_built: bool = False) -> Rig:
        """The rig with fitted parameters and effects written into its quantities, whose source names the recordings."""
        told = [e.recording.path for e in (self.commissioning if as_built else self.experiments)]
        return self.rig_written(theta, acting, spread, f"fitted to {', '.join(told)}", joint)

    def _there(self) -> set[str]:
        """Signals of which the field recordings hold a usable sample."""
        return {name for e in self.field for name in e.signals}

    def missing(self) -> list[str]:
        """Notes on what the field recordings do not hold: signals of the drive and of the hydraulics, all temperatures; none elsewhere."""
        there = self._there()
        warmth = [] if self._sensors_there() else ["there is no temperature sensor but ambient; thermal effects cannot be known"]
        names = [name for name in (*DRIVE_SIGNALS, *HYDRAULIC_SIGNALS) if name not in there]
        alone = "these" if len(names) > 1 else "it"
        return [f"there is no usable {', '.join(names)}; what shows in {alone} alone cannot be known"] * bool(names) + warmth

    def _sensors_there(self) -> list[str]:
        """Temperature sensors beside ambient of which the field recordings hold a usable sample."""
        there = self._there()
        return [sensor for sensor in SENSORS if f"temperature/{sensor}" in there]

    def _rounded(self) -> list[str]:
        """A note on signals that are given in steps coarser than their noise, none where there are none."""
        steps = {name: signal.rounding * math.sqrt(12.0) for e in self.experiments for name, signal in e.signals.items() if signal.rounding}
        if not steps:
            return []
        return [f"{', '.join(steps)}: given in steps of {max(steps.values()):.3g} K at most; what is smaller than these is not seen there"]

    def _held_against(self) -> str:
        """What the unit is held against where it was not recorded as built."""
        if self.rig.given:
            return "there is no commissioning recording: the rig is held against its rig file, and what lies within tolerances is no gap"
        return ("there is no commissioning recording and no rig file: the rig is held against the reference sheet, and what lies within "
                "its tolerances is no gap; a machine that differs from it by design (stroke, pumps ...) needs its own rig file (--rig), "
                "else the difference is told as an effect")

    def notes(self) -> list[str]:
        """What these recordings cannot say, whatever was found."""
        notes = [*self.of_another, *self.missing()]
        there = self._sensors_there()
        unread = [sensor for sensor in SENSORS if sensor not in there]
        if there and unread:
            notes.append(f"the temperatures of {', '.join(unread)} are not read: how warm they are at the start is inferred, what happens "
                         "to their heat is known from the others alone")
        notes += self._rounded()
        if (free := len(set(self.paths) - self.unlisted)) < _FEW:
            notes.append(f"the rig's sheet leaves {free} quantities a tolerance: whatever else differs from it is called an effect or "
                         "unknown")
        if not self.commissioning:
            notes.append(self._held_against())
        return notes
