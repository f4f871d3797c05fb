"""The direct driven hydraulic unit as the diagnosis sees it (`model.Model`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy
from ddh_twin_py.estimation.fitting.experiment import STROKE, Experiment
from ddh_twin_py.estimation.fitting.problem import Problem
from ddh_twin_py.estimation.fitting.unknowns import offset_paths, uncertain_paths, with_offsets
from ddh_twin_py.gap.effect import Acting, apply
from ddh_twin_py.gap.explain.learned import PREFIX
from ddh_twin_py.gap.witnesses import Witnesses
from ddh_twin_py.physics.thermal_network import TANK
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.own_oil import of_own_oil
from ddh_twin_py.rig.payload import PAYLOAD, of_declared_payload
from ddh_twin_py.rig.sheet import BOUNDS, FIELD_OF_PATH, largest_std
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

STEP = 2.0e-3
"""s, hydraulic step of a diagnosis's runs, of rough ones too: what air in the oil, lines and friction do is another at a longer one, and
fits by differences of such runs stop where nothing is at its lowest."""
COARSE = 4.0e-3
"""s, the same of runs that are held against no recording."""
_WINDING = TEMPERATURE_PREFIX + "motor_winding"
WITNESSES = Witnesses({_WINDING: 150.0, STROKE: 24.0}, amplified=(_WINDING,), needed=8.0, needed_beside_none=-2.0)
"""The winding follows the square of every torque, strokes integrate flows. Set on sealed answers; see docs/gap_method.md, section 10."""
_ANEW = 0.5  # K


class DirectDrive:
    """Recordings of one unit and its uncertain parameters; see `model.Model`.

    Args:
        commissioning: recordings of the unit as built. field: those whose gap is asked about. rig: its sheet.
        held: recordings in the field's condition that take no part in finding or fitting.
    """

    difference = 0.05
    witnesses = WITNESSES

    def __init__(self, commissioning: Sequence[Experiment], field: Sequence[Experiment], rig: Rig,
                 held: Sequence[Experiment] = ()) -> None:
        self.commissioning, self.field, self.held = list(commissioning), list(field), list(held)
        self.experiments = [*self.commissioning, *self.field]
        self.first = len(self.commissioning)  # in question
        offsets = offset_paths(self.experiments)
        self.unlisted = set(offsets)  # zero errors and clocks, of which no sheet says anything
        self.rig = with_offsets(rig, offsets)
        uncertain = uncertain_paths(self.rig)
        self.paths = [path for path in uncertain if path not in offsets and not path.startswith("measurement.")]
        self.paths += [path for path in offsets if path in uncertain]
        self.problem = Problem(self.experiments, self.rig, self.paths, Discrepancy())
        self._held_problem = Problem(self.held, self.rig, self.paths, Discrepancy())
        self.size = self.problem.size
        self.altered = [False] * len(self.commissioning) + [True] * len(self.field)
        self.signals = [e.signals for e in self.experiments]

    def within(self, theta: np.ndarray) -> np.ndarray:
        """Deviations (k,) within the cut of the tolerances and the laws of nature."""
        return np.clip(theta, self.problem.lowest, self.problem.highest)

    def run(self, theta: np.ndarray, acting: Acting = ()) -> list[dict[str, np.ndarray]]:
        """Free run of every recording."""
        return [self.run_one(number, theta, acting) for number in range(len(self.experiments))]

    def run_one(self, number: int, theta: np.ndarray, acting: Acting = (), roughly: bool = False) -> dict[str, np.ndarray]:
        """Free run of one recording; effects act where it is altered."""
        return self.experiments[number].predict(self.record(number, theta, acting), STEP, begin=self.problem.begin(number, theta),
                                                roughly=roughly)

    def of_first(self, theta: np.ndarray) -> np.ndarray:
        """Deviations (k,) of the whole case from those of a fit to its first recordings alone; the others begin as is likely."""
        return np.concatenate([theta, np.zeros(self.size - theta.size)])

    def begin_anew(self, theta: np.ndarray, acting: Acting) -> bool:
        """Let field recordings begin as effects would have left what no sensor reads, if a node moves by more than `_ANEW`; if it does."""
        begins = [experiment.other_begin(self.record(number, theta, acting)) for number, experiment in enumerate(self.field, self.first)]
        if max(moved for _, moved in begins) <= _ANEW:
            return False
        for experiment, (rise, _) in zip(self.field, begins, strict=True):
            experiment.begin_with(rise)
        return True

    def held_record(self, number: int, theta: np.ndarray, acting: Acting = ()) -> np.ndarray:
        """Parameter record (1,) of a recording that took no part, effects acting."""
        return apply(acting, self._held_problem.record(number, theta))

    def record(self, number: int, theta: np.ndarray, acting: Acting = ()) -> np.ndarray:
        """Parameter record (1,) of one recording."""
        return apply(acting if self.altered[number] else (), self.problem.record(number, theta))

    def variables(self, comparisons: Sequence[Comparison], theta: np.ndarray, acting: Acting = ()) -> list[dict[str, np.ndarray]]:
        """On what a discrepancy may depend, for every bin, by recording: ``oil temperature`` K and ``speed`` rad/s, (rows,)."""
        out = []
        for number, comparison in enumerate(comparisons):
            record, begin = self.record(number, theta, acting), self.problem.begin(number, theta)
            points, temperatures = self.experiments[number].operating(record, COARSE, begin)
            time = np.concatenate([block.binning.time for block in comparison.blocks])
            axis = self.experiments[number].axis
            out.append({"oil temperature": np.interp(time, axis, temperatures[:, TANK]),
                        "speed": np.interp(time, axis, points["speed_absolute"])})
        return out

    def rig_written(self, theta: np.ndarray, acting: Acting, spread: np.ndarray, source: str, joint: np.ndarray | None = None) -> Rig:
        """The rig with fitted parameters and effects written into its quantities.

        The record of the first recording in which effects act is that of the rig. Recordings and duties declare payloads of their own:
        what a fit or an effect says of the payload is written as ``load.payload_ratio``, its deviation as that of the declared one.

        Args:
            theta, spread: parameters and their standard deviations, in deviations, (k,). source: where the values come from.
            joint: covariance of parameters and departures, (k + m, k + m); None where the departures are exact.
        """
        quantities = dict(self.rig.quantities)
        for path, deviation, std, scale in zip(self.paths, theta, spread, self.problem.scale, strict=False):  # begins are not the rig's
            bound = BOUNDS[path]
            value = min(max(quantities[path].value + float(deviation * scale), bound.lowest), bound.highest)
            quantities[path] = replace(quantities[path], value=value, std=float(std * scale), source=source)
        fitted = replace(self.rig, quantities=of_own_oil(quantities, self.rig.quantities))
        plain, acted = self.record(self.first, theta), self.record(self.first, theta, acting)
        written = {path: field for path, field in FIELD_OF_PATH.items() if acted[field][0] != plain[field][0]}
        stds = self._stds(theta, acting, list(written.values()), np.diag(spread**2) if joint is None else joint)
        named = ", ".join(effect.id for effect, _, _ in acting)
        said = "learned, cause unknown" if named.startswith(PREFIX) else f"effect {named}"
        quantities = dict(fitted.quantities)
        for (path, field), std in zip(written.items(), stds, strict=True):
            whole = float(fitted[path] / plain[field][0]) if path == PAYLOAD else 1.0
            value = float(acted[field][0]) * whole
            quantities[path] = replace(quantities[path], value=value, std=min(float(std) * whole, largest_std(path, value)),
                                       source=f"{said}, {source}")
        return replace(fitted, quantities=of_declared_payload(quantities, self.rig.quantities))

    def _stds(self, theta: np.ndarray, acting: Acting, fields: Sequence[str], joint: np.ndarray) -> np.ndarray:
        """Standard deviations of fields of a record, (f,), of fit and laws; joint as in `rig_written`."""
        def values(at: np.ndarray, departures: Sequence[float]) -> np.ndarray:
            record = self.record(self.first, at, [(effect, law, x) for (effect, law, _), x in zip(acting, departures, strict=True)])
            return np.array([record[field][0] for field in fields])

        x = [departure for _, _, departure in acting]
        base, slopes = values(theta, x), []
        for i in range(theta.size):
            moved = theta.copy()
            moved[i] += self.difference
            slopes.append((values(moved, x) - base) / self.difference)
        by_law = np.zeros(len(fields))
        for j, (effect, _, departure) in enumerate(acting):
            change = self.difference * departure
            slope = (values(theta, [*x[:j], departure + change, *x[j + 1 :]]) - base) / change if change else np.zeros(len(fields))
            by_law += (effect.law_error * slope * departure) ** 2
            if joint.shape[0] > theta.size:
                slopes.append(slope)
        slope = np.array(slopes)
        return np.sqrt(np.maximum(np.einsum("if,ij,jf->f", slope, joint, slope), 0.0) + by_law)
