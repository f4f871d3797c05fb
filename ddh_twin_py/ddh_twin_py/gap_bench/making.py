"""Make one sealed case: recordings into OUT/cases, the truth into OUT/truth."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.gap_bench.duties import Duty, drawn
from ddh_twin_py.gap_bench.plan import PlanError, Planned
from ddh_twin_py.gap_bench.recordings import recording_of
from ddh_twin_py.gap_bench.sealing import RECORDINGS, digest_of
from ddh_twin_py.gap_bench.sizes import sized, worst
from ddh_twin_py.gap_bench.visibility import Feigned, scene
from ddh_twin_py.plant.fault import Fault
from ddh_twin_py.plant.listed_faults import LISTED
from ddh_twin_py.plant.machine import Machine, build
from ddh_twin_py.plant.sensors import SENSORS, Instruments, measure
from ddh_twin_py.plant.unlisted_faults import NEEDS_SENSOR, UNLISTED
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.files import write_whole

PARTS = ("commissioning", "field", "validation")
_DAY = 86_400 * 10**9
_FIRST_DAY = 1_767_225_600 * 10**9  # 2026-01-01
_WIDENED = 1.6
_LONGEST_FEIGNED = 700.0  # s of a duty on which it is asked what tolerances can feign


@dataclass(frozen=True)
class Hidden:
    """An effect as it was hidden: its departure, the reported value, the signal that it moves most and how far."""

    fault: Fault
    departure: float
    value: float
    nominal: float
    signal: str
    rise: float


def make(planned: Planned, out: Path, sheet: Rig) -> Path:
    """Write a case's bags and its truth; a case whose truth is there is left alone.

    Raises:
        PlanError: no effect of the plan is possible at this level, or the plant left the numbers; no folder of the case is left.
    """
    target = out / "truth" / f"{planned.name}.yaml"
    folder = out / "cases" / planned.name
    if target.is_file():
        return target
    rng = np.random.default_rng((planned.seed, 0x5EA1))
    machine = build(sheet, rng, _WIDENED if planned.suite == "tolerance" else 1.0)
    instruments = Instruments.drawn(sheet, machine.rig["sensors.temperature.time_constant"], rng)
    sensors = _sensors(planned, rng)
    rate, slow = float(rng.choice([20.0, 20.0, 25.0, 40.0, 50.0])), float(rng.choice([0.5, 1.0]))
    payload = [round(float(rng.uniform(65.0, 285.0)), 1) for _ in range(2)]
    if rng.random() < 0.6:
        payload[1] = payload[0]
    duties = {
        "commissioning": drawn(rng, 600.0, round(float(rng.uniform(80.0, 250.0)), 1), rate, False),
        "field": drawn(rng, _field_seconds(planned, rng), payload[0], rate, bool(rng.random() < 0.5)),
        "validation": drawn(rng, 540.0, payload[1], rate, bool(rng.random() < 0.6)),
    }
    machine, hidden = _hide(planned, machine, instruments, duties["field"], sensors, sheet, rng)
    faults = [(h.fault, h.departure) for h in hidden]
    if folder.exists():
        shutil.rmtree(folder)
    day = _FIRST_DAY + int(rng.integers(0, 200)) * _DAY
    after = {"commissioning": 0, "field": int(rng.integers(20, 200)) * _DAY, "validation": 0}
    after["validation"] = after["field"] + 7200 * 10**9
    for part in PARTS:
        if part == "commissioning" and not planned.commissioning:
            continue
        duty = duties[part]
        course = machine.run(duty.exercise, [] if part == "commissioning" else faults, duty.drive_time, duty.hydraulic_time)
        if not (np.isfinite(course.drive).all() and np.isfinite(course.hydraulic).all() and np.isfinite(course.temperatures).all()):
            shutil.rmtree(folder, ignore_errors=True)
            raise PlanError(f"{planned.name}: {part}: the plant left the numbers, hidden are {[h.fault.id for h in hidden]}")
        readings = measure(course, instruments, duty.exercise.ambient, sensors, slow, rng)
        write_recording(folder / part, recording_of(readings, planned.name, duty.exercise.payload, day + after[part]))
    truth = _truth(planned, hidden, sensors, machine, sheet) | {RECORDINGS: digest_of(folder)}
    write_whole(target, yaml.safe_dump(truth, sort_keys=False, width=120))
    return target


def _field_seconds(planned: Planned, rng: np.random.Generator) -> float:
    """10 to 15 min; up to 30 where a slow effect is wanted first, and now and then for nothing."""
    slow = any((LISTED.get(name) or UNLISTED[name]).domain == "thermal" for name in planned.effects[: planned.hidden])
    low, high = (1200, 1801) if slow or rng.random() < 0.15 else (600, 901)
    return float(rng.integers(low, high))


def _sensors(planned: Planned, rng: np.random.Generator) -> tuple[str, ...]:
    """All sensors, or the few that most machines have."""
    if rng.random() < 0.7:
        return SENSORS
    kept = {name for name in SENSORS if rng.random() < 0.45} | {"ambient", str(rng.choice(["motor_housing", "motor_winding"]))}
    if planned.effects and planned.effects[0] in NEEDS_SENSOR:
        kept.add(NEEDS_SENSOR[planned.effects[0]])
    return tuple(name for name in SENSORS if name in kept)


def _hide(planned: Planned, machine: Machine, instruments: Instruments, duty: Duty, sensors: tuple[str, ...], sheet: Rig,
          rng: np.random.Generator) -> tuple[Machine, list[Hidden]]:
    """The machine, as it is without effects, and what is hidden in it."""
    view = scene(machine, instruments, duty, sensors)
    hidden: list[Hidden] = []
    for name in planned.effects:
        if len(hidden) == planned.hidden:
            break
        fault = LISTED.get(name) or UNLISTED[name]
        if any(h.fault.component == fault.component and h.fault.domain == fault.domain for h in hidden):
            continue  # two at once lie in different places
        sign = float(rng.choice(fault.signs))
        if planned.commissioning:
            found = sized(fault, sign, planned.level, view, None)
        else:
            machine = as_sheet(machine, fault, sheet)
            view = scene(machine, instruments, duty.shortened(_LONGEST_FEIGNED), sensors)
            found = sized(fault, sign, planned.level, view, Feigned(sheet, view))
        if found is None:
            continue
        record = machine.rig.parameters
        record["load_payload_mass"] = duty.exercise.payload * machine.payload_ratio
        nominal = fault.nominal(record)
        signal, rise = worst(view, fault, found)
        change = -found if name == "motor.demagnetisation" else found
        hidden.append(Hidden(fault, found, nominal + change, nominal, signal, rise))
    if len(hidden) < planned.hidden:
        raise PlanError(f"{planned.name}: no {planned.hidden} effects of the plan are possible at level {planned.level}")
    return machine, hidden


def as_sheet(machine: Machine, fault: Fault, sheet: Rig) -> Machine:
    """The machine with the sheet's own value of what an effect changes, so that its size is said against the sheet."""
    values = {path: sheet[path] for path, _ in fault.paths if path != "load.payload_mass"}
    return Machine(machine.rig.built_as(values, "as the sheet says"), 1.0 if fault.id == "load.mass" else machine.payload_ratio)


def _truth(planned: Planned, hidden: list[Hidden], sensors: tuple[str, ...], machine: Machine, sheet: Rig) -> dict:
    expected = {"none": "no_gap", "tolerance": "no_gap", "left_out": "unknown", "outside": "unknown"}.get(planned.suite, "explained")
    return {
        "name": planned.name, "suite": planned.suite, "level": planned.level, "expected": expected,
        "commissioning": planned.commissioning, "seed": planned.seed, "sensors": list(sensors),
        "effects": [
            {
                "effect": h.fault.id, "listed": h.fault.listed, "component": h.fault.component, "domain": h.fault.domain,
                "parameter": h.fault.parameter, "unit": h.fault.unit, "value": float(h.value), "nominal": float(h.nominal),
                "worst_signal": h.signal, "worst_rise": round(float(h.rise), 3),
            }
            for h in hidden
        ],
        "rig": {path: float(machine.rig[path]) for path, q in sheet.quantities.items() if q.tolerance > 0.0},
    }
