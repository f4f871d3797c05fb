"""Temperatures within a sensor's range that are likely in another unit or of the other sign, or exchanged, told by the places about them.

Of 20 degC a sensor in degF makes 68, which none of this machine's ranges forbids; what is beyond them is screening's. Where most
sensors are in degF and the air is cool, nothing tells; nor does it of air that reads frost where it need not be, or of a winding in degF on
a unit that is warm from before.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.telemetry.in_order import in_order
from ddh_twin_py.telemetry.recording import Finding, Recording, Stream
from ddh_twin_py.telemetry.signals import (
    DEGF,
    OTHER_SIGN,
    TEMPERATURE_PREFIX,
    TEMPERATURE_SENSORS,
    TENTHS,
    ZERO_CELSIUS,
    UnitMistake,
    signals_of,
)
from ddh_twin_py.telemetry.units.unit_scales import UnitScales

LEAST = 20
"""Samples that tell something."""
_SHARE = 0.05  # of the samples, coldest or warmest, that may be otherwise
_HOT = 55.0  # degC, of air that hardly any place has
_RESTED = 2.0  # K by which a motor that has rested differs from the air, and air of the other sign from what has rested in it
_ALIKE = 3.0  # K by which places of a unit that has rested differ at most
_COLDER = 20.0  # K by which what is read is colder than the others where its sign is the other one
_BEGIN, _TIE = 5, 1.0  # first readings, and K by which two units fit them about as well
_FOLLOWS = 1.0  # K by which the others must have warmed for what is read to show whether it does
_HOTTER = 3.0  # K by which exchanged air is the hottest of all
_COLDER_THAN_ALL = 2.0  # K by which an exchanged winding, the coldest of all, is colder than its housing
_HEATS, _COLDER_WINDING = 30.0, 1.0  # W of copper loss, on average, from which no winding is so many K colder than its housing
_OF_MOTOR = ("motor_winding", "motor_housing")
_WITH_OIL = ("pump_1_case", "pump_2_case", "tank_oil", "tank_wall", "cylinder_barrel", "line_a", "line_b")
_HELD_AGAINST = {  # degF adds 32 K at 0 degC and more above
    "ambient": (np.min, TEMPERATURE_SENSORS, 30.0, (-60.0, 3.0), "the coldest place of the machine"),
    "motor_winding": (np.min, ("motor_housing",), 30.0, (-5.0, 45.0), "motor_housing"),
    "motor_housing": (np.min, ("motor_winding",), 15.0, (-45.0, 5.0), "motor_winding"),
    **dict.fromkeys(_WITH_OIL, (np.median, _WITH_OIL, 30.0, (-10.0, 10.0), "the median of the others that hold oil")),
}
"""What of which others each sensor is held against; by how much, K, it never is warmer, and how much warmer it is at least and at most; the
same in words."""


Read = Mapping[str, tuple[np.ndarray, np.ndarray]]
"""Times, s, and degC in order of time, by sensor."""


def odd_temperatures(recording: Recording, scales: UnitScales | None) -> dict[str, Finding]:
    """What is said of each temperature topic, relative, that is in another unit or of the other sign, or whose place is another's."""
    read, found = _of(recording), {}
    for name, text in odd_beside_others(read, _heats(recording, scales)).items():
        topic = f"{TEMPERATURE_PREFIX}{name}"
        (signal,), where = signals_of(topic), f"{recording.namespace}/{topic}"
        time, own = read[name]
        found[topic] = Finding("error", recording.path, where, signal.field, float(own[0]), own.size,
                               f"{recording.path}: {where} {text}; not used", float(time[0]))
    return found


def odd_beside_others(read: Read, heats: bool = False) -> dict[str, str]:
    """What is said of each sensor that is odd beside the others, behind its name; those that are make no other odd.

    ``heats``: whether the motor's current is known to heat its winding.
    """
    said = _exchanged_with_air(read, heats)
    while more := {name: text for name in read if name not in said
                   and (text := _beside_others(name, {other: read[other] for other in read if other not in said}))}:
        said |= more
    return {name: f"temperature {text}" for name, text in said.items()}


def temperature_units(recording: Recording) -> list[str]:
    """One sentence for each topic that is odd beside the others or is air as hot as hardly ever; without the recording's name."""
    read = _of(recording)
    said = odd_beside_others(read)
    if "ambient" in read and "ambient" not in said and (hot := _hot_air(read["ambient"][1])):
        said["ambient"] = f"temperature {hot}"
    return [f"{recording.namespace}/{TEMPERATURE_PREFIX}{name} {said[name]}" for name in read if name in said]


def _of(recording: Recording) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {name: read for name, stream in recording.temperatures.items() if (read := _readings(stream))[0].size >= LEAST}


def _readings(stream: Stream) -> tuple[np.ndarray, np.ndarray]:
    """Times and degC of what was read, in order of time."""
    known = in_order(stream.time, stream.values[:, 0])
    return stream.time[known], stream.values[known, 0] - ZERO_CELSIUS


def _beside_others(name: str, read: Read) -> str:
    """That a reading is far off the others and would fit them in another unit; '' where it is not."""
    which, places, never, (lowest, highest), words = _HELD_AGAINST[name]
    time, own = read[name]
    others = [np.interp(time, *read[place]) for place in places if place in read and place != name]
    possible = (DEGF, TENTHS, OTHER_SIGN)
    if not others and name == "motor_housing":  # beside the oil, than which it may be much warmer
        which, others, possible = np.median, [np.interp(time, *read[place]) for place in _WITH_OIL if place in read], (OTHER_SIGN,)
        lowest, highest, words = -10.0, 45.0, "the median of those that hold oil"
    if not others or name in _OF_MOTOR and not _farther(name, read):
        return ""
    against = which(others, axis=0)
    units = []
    for unit in possible:
        least, most = np.quantile(_right(unit, own) - against, (_SHARE, 1.0 - _SHARE))
        if lowest <= least and most <= highest and (
                _other_sign(name, time, own, against, read) if unit is OTHER_SIGN else np.quantile(own - against, _SHARE) >= never):
            units.append(unit)
    if name == "motor_winding" and "ambient" in read and abs(against[0] - read["ambient"][1][0]) > _RESTED:
        units = [unit for unit in units if unit is not DEGF]  # a winding at work is warmer than its housing by as much
    if not units:
        return ""
    begin = slice(_BEGIN)
    off = {unit.unit: abs(float(np.median(_right(unit, own[begin]) - against[begin]))) for unit in units}
    units = [unit for unit in units if off[unit.unit] <= min(off.values()) + _TIE]
    return (f"looks as if given in {' or '.join(unit.unit for unit in units)}: it reads {own.mean():.0f} degC on average, {words} "
            f"{against.mean():.0f} degC; it would be {' or '.join(f'{_right(unit, own).mean():.0f}' for unit in units)} degC")


def _farther(name: str, read: Read) -> bool:
    """Whether of winding and housing, each of which the other is held against, this is farther off all other places."""
    rest = [np.median(own) for place, (_, own) in read.items() if place not in _OF_MOTOR]
    off = {place: abs(float(np.median(read[place][1]) - np.median(rest))) for place in _OF_MOTOR if place in read} if rest else {}
    return not off or off[name] == max(off.values())


def _other_sign(name: str, time: np.ndarray, own: np.ndarray, against: np.ndarray, read: Read) -> bool:
    """Whether a reading is so much colder than the others that its sign is the other one, if it may be.

    Air may well be as cold: where all others have rested, its sign is wrong if they are as much above zero as it is below. Elsewhere what
    is read cools where that which holds oil warms.
    """
    if np.quantile(own - against, 1.0 - _SHARE) > -_COLDER:
        return False
    if name == "ambient":
        begin = [other[0] for place, (_, other) in read.items() if place != name]
        return bool(len(begin) > 1 and np.ptp(begin) <= _ALIKE and abs(own[0] + np.median(begin)) <= _RESTED)
    oil = [np.interp(time, *read[place]) for place in _WITH_OIL if place in read and place != name]
    warmed = _change(np.median(oil, axis=0)) if oil else 0.0
    return abs(warmed) < _FOLLOWS or _change(own) * warmed <= 0.0


def _exchanged_with_air(read: Read, heats: bool) -> dict[str, str]:
    """What is said of ambient and winding where each reads what the other must: over the last half the air is hotter than all that it
    cools, and the winding colder than its housing that it heats, or, where nothing tells that it does, than all."""
    if not {"ambient", "motor_winding", "motor_housing"} <= set(read):
        return {}
    late = {name: float(np.median(own[time >= 0.5 * (time[0] + time[-1])])) for name, (time, own) in read.items()}
    air, winding = late.pop("ambient"), late.pop("motor_winding")
    if len(late) < 2 or air < max(late.values()) + _HOTTER:
        return {}
    warms = _change(read["motor_housing"][1]) > _change(read["motor_winding"][1])
    if winding > (late["motor_housing"] - _COLDER_WINDING if heats else min(late["motor_housing"] - _COLDER_THAN_ALL, *late.values())):
        return {}
    if not (heats or warms):
        return {}
    text = (f"is likely that of {{}}: ambient reads {air:.0f} degC and motor_winding {winding:.0f} degC, all others "
            f"{min(late.values()):.0f} to {max(late.values()):.0f} degC; their sensors are likely exchanged")
    return {"ambient": text.format("motor_winding"), "motor_winding": text.format("ambient")}


def _heats(recording: Recording, scales: UnitScales | None) -> bool:
    """Whether the motor's current heats its winding so that it is warmer than its housing."""
    if recording.drive is None or scales is None:
        return False
    square = recording.drive.column("current") ** 2
    return bool(np.isfinite(square).any() and 3.0 * scales.phase_resistance * np.nanmean(square) > _HEATS)


def _change(values: np.ndarray) -> float:
    """From begin to end, K."""
    tenth = max(1, values.size // 10)
    return float(np.median(values[-tenth:]) - np.median(values[:tenth]))


def _hot_air(read: np.ndarray) -> str:
    """That the air is as hot as hardly ever; '' where it is not. All others may be in degF as well, as one device reads them."""
    if np.quantile(read, _SHARE) < _HOT:
        return ""
    return (f"looks as if given in degF, perhaps with others: it reads {read.mean():.0f} degC on average, as warm as air hardly ever is; "
            f"it would be {_right(DEGF, read).mean():.0f} degC")


def _right(unit: UnitMistake, celsius: np.ndarray) -> np.ndarray:
    """degC of readings in another unit, as read in degC."""
    return unit.corrected(celsius + ZERO_CELSIUS) - ZERO_CELSIUS
