"""What a fit does not know: the rig's uncertain quantities, and what no sheet lists but every recording needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ddh_twin_py.estimation.fitting.comparison import CLOCK_JITTER
from ddh_twin_py.estimation.fitting.experiment import PRESSURES, Experiment
from ddh_twin_py.rig import Rig

AIR = "surroundings.enclosure_rise"
"""What the ambient sensor's zero error comes to: the air is warmer than it reads."""
SKEW = "measurement.time_skew"
"""How much later hydraulic samples are stamped than the drive's; unknown by `CLOCK_JITTER`."""
_ALLOWED = {SKEW: (CLOCK_JITTER, "clocks of drive and pressures")}
"""Standard deviation of what else no sheet lists, and why."""


def uncertain_paths(rig: Rig) -> list[str]:
    """Paths of the quantities that have a tolerance."""
    return [path for path, quantity in rig.quantities.items() if quantity.standard_deviation > 0.0]


def offset_paths(experiments: Sequence[Experiment]) -> list[str]:
    """Paths of what no sheet lists and every fit needs: zero errors of the sensors that the recordings have, clocks."""
    signals = dict.fromkeys(name for e in experiments for name in e.signals)
    names = [name if name in PRESSURES else name.split("/")[1] for name in signals if name in PRESSURES or "/" in name]
    air = any("ambient" in e.recording.temperatures for e in experiments)
    return [f"measurement.{name}_offset" for name in names] + [AIR] * air + [SKEW]


def same_everywhere(path: str) -> bool:
    """Whether every reading is a linear function of a zero error, whatever else is fitted: those that do not reach the oil."""
    return path.startswith(("measurement.pressure_", "measurement.motor_")) and path.endswith("_offset")


def with_offsets(rig: Rig, paths: Sequence[str]) -> Rig:
    """The rig with the sheet's tolerance on those zero errors that nothing is known of yet."""
    quantities = dict(rig.quantities)
    for path in paths:
        sensor = rig.sensors["pressure" if path.startswith("measurement.pressure") else "temperature"]
        if quantities[path].standard_deviation == 0.0:
            std, what = _ALLOWED.get(path, (sensor.offset_tolerance, "the sensor's zero"))
            quantities[path] = replace(quantities[path], std=std, source=what)
    return replace(rig, quantities=quantities)
