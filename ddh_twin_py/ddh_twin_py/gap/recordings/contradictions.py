"""Channels of one recording that cannot all be right: a sign, two channels exchanged, a clock, a unit, another rig's geometry.

Such a recording leaves a gap that no effect explains, or worse, that one feigns. What is said here stands beside any verdict.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ddh_twin_py.gap.recordings.carried_load import carried
from ddh_twin_py.gap.recordings.winding_place import warms_instead
from ddh_twin_py.physics.cylinder import load_force, piston_area, rod_side_area, rod_travel
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.clocks.clock import clock_segments
from ddh_twin_py.telemetry.in_order import in_order
from ddh_twin_py.telemetry.recording import Recording, Stream
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC
from ddh_twin_py.telemetry.spans import set_off
from ddh_twin_py.telemetry.ticks import REORDER_WINDOW, to_ns
from ddh_twin_py.telemetry.units.temperature_units import temperature_units

_STEP = 0.1  # s, of the common axis
_TURNING, _MOVING = 10.0, 0.01  # rad/s, m/s: a shaft that turns, a rod that moves
_HARDLY = 1.0  # what of that is left in rev/s
_PAUSE = 60.0  # s without a sample that are left out
_LEAST = 100  # points of the axis that tell something
_AGAINST = -0.5  # correlation from which two channels run against each other
_LATEST, _LATE = 10.0, 0.3  # s of lag that is looked for, and that is told
_ALIKE, _LESS = 0.1, 2.0  # correlation that it must gain, or times by which it lessens what is left to 1
_FOLLOWS = 0.5  # correlation of shaft and rod from which they are of one machine, by clocks that are apart
_FOLLOWED, _SCATTER = 1.25, 0.1  # how far a steady shaft may be from its command, as a ratio, and how little that ratio varies elsewhere
_APACE, _SAME_WAY, _ALONG = 1.5, 0.95, 25  # times as far as its velocity says that a rod must go to be told, where both correlate so, over
# so many samples
_TRAVELLED = 2.0  # how many times as fast as its pump delivers, or as slowly, a rod must move to be told
_ANOTHER = 1.15  # such times from which it is told where they are the same both ways, as leakage slows one and speeds up the other
_BOTH_WAYS = 1.2  # ratio of the two up to which they are the same
_BEYOND = 1.05  # strokes that a rod must travel to be told
_MOSTLY, _COLDER = 0.9, 1.0  # share of the time, and K, for which a winding must be colder than its housing to be told
_GO_TOGETHER = 0.8  # correlation of the torque that pressures ask for with that which the current makes
_BRAKES, _NO_CURRENT = -1.0, -0.2  # N*m below which the drive brakes, and A above which its current does not
_TIMES = 5.0  # how many times as much one must be as the other to be told
_BETTER = 4.0  # times by which exchanged pressures must fit the load better
_BETTER_TURNED = 1.5  # times by which pressures one way round must fit the torque of the current better to be held for right


def contradictions(recording: Recording, rig: Rig) -> list[str]:
    """One sentence for each, naming recording and topics; none where a stream is missing or nothing moves.

    Args:
        rig: areas of the cylinder, and the load where the recording tells none.
    """
    drive, hydraulic = recording.drive, recording.hydraulic
    if drive is None or hydraulic is None or min(len(drive), len(hydraulic)) < _LEAST:
        return []
    warmth = temperature_units(recording) or [text for text in [_winding(recording) or warms_instead(recording)] if text]
    if off := other_clock(recording):
        return [off, *(f"{recording.path}: {text}" for text in warmth)]
    if pace := _pace(hydraulic):  # with stamps that are no seconds nothing else is held against each other
        return [f"{recording.path}: {text}" for text in (_named(pace, recording), *warmth)]
    on = _on(drive, hydraulic)
    if not on:
        return []
    travel = _shaft(on, rig) or _travel(on, rig)
    torque = "" if travel else _torque(on, rig)  # of other pumps it says nothing
    said = [_command(on), _position(on), travel, _stroke(hydraulic, rig), _current(on) or _unsigned(drive),
            torque or _pressures(on, recording, rig)]
    said = [_named(text, recording, rig.file) for text in said if text]
    return [f"{recording.path}: {text}" for text in (*said, *warmth)]


def other_clock(recording: Recording) -> str:
    """That drive and hydraulics are of clocks seconds or minutes apart, in one line; '' where they are not, or nothing tells it.

    Begin and end of both are apart alike, and the rod follows the shaft better where that is taken off.
    """
    drive, hydraulic = recording.drive, recording.hydraulic
    if drive is None or hydraulic is None or min(len(drive), len(hydraulic)) < _LEAST:
        return ""
    off = set_off(drive.time, hydraulic.time)
    if off is None:
        return ""
    as_is, moved = _on(drive, hydraulic), _on(replace(drive, time=drive.time - off), hydraulic)
    late, best = _late(moved)
    if best < _FOLLOWS or as_is and best < _together(as_is, 0) + _ALIKE:
        return ""
    return f"{recording.path}: {_named(_clocks_differ(late - off), recording)}"


def _named(text: str, recording: Recording, rig: str = "") -> str:
    drive, hydraulic = (f"{recording.namespace}/{topic}" for topic in (DRIVE_TOPIC, HYDRAULIC_TOPIC))
    return text.format(drive=drive, hydraulic=hydraulic, rig=rig)


def _on(drive: Stream, hydraulic: Stream) -> dict[str, np.ndarray]:
    """Fields of both streams on one axis, (n,) each, from one jump back of the clock to the next; none where they have too little time in
    common. ``inner``: further than `_LATEST` from such a jump and from both ends."""
    parts = [on for one, other in _stretches(drive, hydraulic) if (on := _between_jumps(one, other))]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else {}


def _stretches(drive: Stream, hydraulic: Stream) -> list[tuple[Stream, Stream]]:
    """Both streams from one jump back of the clock to the next, without those of which there is too little."""
    segments = clock_segments({"drive": drive.stamps(0), "hydraulic": hydraulic.stamps(0)}, to_ns(REORDER_WINDOW)).values()
    count = 1 + min(int(segment[-1]) for segment in segments)
    edges = [np.searchsorted(segment, np.arange(count + 1)) for segment in segments]
    enough = np.flatnonzero(np.all([np.diff(edge) >= _LEAST for edge in edges], axis=0))
    return [tuple(replace(stream, time=stream.time[edge[k] : edge[k + 1]], values=stream.values[edge[k] : edge[k + 1]])
                  for stream, edge in zip((drive, hydraulic), edges, strict=True)) for k in enough.tolist()]


def _between_jumps(drive: Stream, hydraulic: Stream) -> dict[str, np.ndarray]:
    axis = _axis(drive, hydraulic)
    if axis.size < _LEAST:
        return {}
    on = {name: _resampled(drive, name, axis) for name in ("speed_command", "speed", "current")}
    on |= {name: _resampled(hydraulic, name, axis) for name in
           ("rod_velocity", "rod_position", "pressure_piston_side", "pressure_rod_side")}
    edge, places = round(_LATEST / _STEP), np.arange(axis.size)
    return on | {"inner": (places >= edge) & (places < axis.size - edge)}


def _axis(one: Stream, other: Stream) -> np.ndarray:
    """Times each `_STEP` that both streams span, s, without those of pauses: they grow with the samples, not with the span."""
    begin, end = max(one.time.min(), other.time.min()), min(one.time.max(), other.time.max())
    time = np.sort(np.concatenate([one.time, other.time]))
    time = np.concatenate([[begin], time[(time > begin) & (time < end)], [max(begin, end)]])
    long = np.flatnonzero(np.diff(time) > _PAUSE)
    if not long.size:
        return np.arange(begin, end, _STEP)
    starts, stops = [begin, *time[long + 1]], [*time[long], end]
    return np.concatenate([np.arange(start, stop, _STEP) for start, stop in zip(starts, stops, strict=True)])


def _resampled(stream: Stream, name: str, axis: np.ndarray) -> np.ndarray:
    """A field on an axis, (n,), NaN where it has no number."""
    values = stream.values[:, stream.fields.index(name)]
    known = in_order(stream.time, values)
    return np.interp(axis, stream.time[known], values[known]) if known.size > _LEAST else np.full(axis.size, np.nan)


def _command(on: dict[str, np.ndarray]) -> str:
    """The speed against its command: whether it stands still, its sign, and its size while both are steady."""
    command, speed = on["speed_command"], on["speed"]
    here = np.isfinite(command) & np.isfinite(speed)
    if here.sum() < _LEAST:
        return ""
    if np.ptp(command[here]) == 0.0 and np.ptp(speed[here]) > 2.0 * _TURNING:
        return (f"{{drive}}: speed_command is {command[here][0]:.4g} rad/s throughout while speed goes from {speed[here].min():.4g} to "
                f"{speed[here].max():.4g} rad/s; it is not the command that the drive followed")
    if _correlation(command, speed, here) < _AGAINST:
        return "{drive}: speed is positive while speed_command is negative; one of the two has the wrong sign"
    steady = here & (np.gradient(command) == 0.0) & (np.abs(speed) > _TURNING) & (command != 0.0)
    steady &= np.abs(np.gradient(speed)) < 0.05 * np.abs(speed)
    ratio = _odd(speed[steady] / command[steady], _FOLLOWED)
    if ratio is None:
        return ""
    return f"{{drive}}: while both are steady, speed is {ratio:.3g} times speed_command; one of the two is likely in another unit"


def _position(on: dict[str, np.ndarray]) -> str:
    """Position against velocity."""
    travelled, velocity = np.gradient(on["rod_position"], _STEP), on["rod_velocity"]
    moving = np.abs(velocity) > _MOVING
    if _correlation(travelled, velocity, moving) > _AGAINST:
        return ""
    return "{hydraulic}: rod_position falls while rod_velocity says that the rod extends; one of them counts from the other end"


def _pace(hydraulic: Stream) -> str:
    """Position against velocity: how far the rod goes in the time that the stamps tell, be all of that a fraction of a second."""
    position, velocity = hydraulic.column("rod_position"), hydraulic.column("rod_velocity")
    known = in_order(hydraulic.time, position + velocity)
    time, position, velocity = hydraulic.time[known], position[known], velocity[known]
    if known.size < _LEAST:
        return ""
    travelled = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time))])
    went, said = (path[_ALONG:] - path[:-_ALONG] for path in (position, travelled))
    moving = np.abs(velocity[_ALONG:]) > _MOVING
    if not said[moving].any() or _correlation(went, said, moving) < _SAME_WAY:
        return ""
    times = float(went[moving] @ said[moving] / (said[moving] @ said[moving]))
    if 1.0 / _APACE < times < _APACE:
        return ""
    return (f"{{hydraulic}} rod_position goes {times:.4g} times as far as rod_velocity says for the time between the stamps; seconds of "
            f"header.stamp are likely too {'short' if times > 1.0 else 'long'} by that, as where they are in another unit, else one of the "
            "two is")


def _shaft(on: dict[str, np.ndarray], rig: Rig) -> str:
    """Velocity against speed: its sign, and whether it comes later than the rig file says."""
    speed, velocity = on["speed"], on["rod_velocity"]
    here = np.isfinite(speed) & np.isfinite(velocity)
    if _correlation(speed, velocity, here) < _AGAINST:
        return "{drive} speed is positive while {hydraulic} rod_velocity says that the rod retracts; one of the two has the wrong sign"
    late, best = _late(on)
    known = rig["measurement.time_skew"]
    as_is = _together(on, round(known / _STEP))
    better = best >= as_is + _ALIKE or best >= _FOLLOWS and 1.0 - as_is >= _LESS * (1.0 - best)
    return _clocks_differ(late) if abs(late - known) > _LATE - 0.5 * _STEP and better else ""


def _late(on: dict[str, np.ndarray]) -> tuple[float, float]:
    """By how many s the rod's velocity comes later than the shaft's speed where both go together best, and how well they do there."""
    if not on:
        return 0.0, 0.0
    steps = round(_LATEST / _STEP)
    lags = np.arange(-steps, steps + 1)
    found = [_together(on, lag) for lag in lags]
    best = int(np.argmax(found))
    return float(lags[best] * _STEP), found[best]


def _together(on: dict[str, np.ndarray], lag: int) -> float:
    """Correlation of velocity with a speed that is taken so many steps later, without the ends."""
    inner, known = on["inner"], np.isfinite(on["speed"] + on["rod_velocity"])
    return _correlation(np.roll(on["speed"], lag)[inner], on["rod_velocity"][inner], known[inner])


def _clocks_differ(late: float) -> str:
    way = "later" if late < 0.0 else "earlier"
    return f"{{hydraulic}} follows {{drive}} best when it is taken {abs(late):.1f} s {way}; their clocks differ"


def _travel(on: dict[str, np.ndarray], rig: Rig) -> str:
    """Velocity against speed: its size, beside what the pump delivers."""
    speed, velocity = on["speed"], on["rod_velocity"]
    moving = np.isfinite(speed) & np.isfinite(velocity) & (np.abs(speed) > _HARDLY) & (np.abs(velocity) > _MOVING)
    travelled = velocity / np.where(moving, speed * float(rod_travel(rig.parameters[0])), 1.0)
    made = "what {drive} speed makes of it with pump 1 and the piston of {rig}"
    if ratio := _odd(travelled[moving], _TRAVELLED):
        return (f"{{hydraulic}} rod_velocity is {ratio:.3g} times {made}; one of the two is likely in another unit, or is that not the rig "
                "file of this machine?")
    moving &= np.abs(speed) > _TURNING
    ways = [_odd(travelled[moving & (sign * speed > 0.0)], 1.0) for sign in (1.0, -1.0)]
    if None in ways or min(ways) <= 0.0 or max(ways) > _BOTH_WAYS * min(ways):
        return ""
    ratio = math.sqrt(ways[0] * ways[1])
    if 1.0 / _ANOTHER < ratio < _ANOTHER:
        return ""
    return f"{{hydraulic}} rod_velocity is {ratio:.3g} times {made}, up and down alike; is that the rig file of this machine?"


def _stroke(hydraulic: Stream, rig: Rig) -> str:
    """How far the rod goes, beside the stroke."""
    position = hydraulic.column("rod_position")
    position = position[np.isfinite(position)]
    if position.size < _LEAST:
        return ""
    low, high = np.quantile(position, [0.01, 0.99])
    stroke = rig["cylinder.stroke"]
    if high - low < _BEYOND * stroke:
        return ""
    return (f"{{hydraulic}} rod_position goes from {low:.3g} to {high:.3g} m, and the stroke in {{rig}} is {stroke:.3g} m; is that the rig "
            "file of this machine?")


def _current(on: dict[str, np.ndarray]) -> str:
    """Friction asks for more current one way than the other, whatever the load."""
    known = np.isfinite(on["current"])
    lifting, lowering = (on["current"][known & (sign * on["speed"] > _TURNING)] for sign in (1.0, -1.0))
    if min(lifting.size, lowering.size) < _LEAST or lifting.mean() >= lowering.mean() - (lifting.std() + lowering.std()):
        return ""
    return (f"{{drive}}: the current is {lifting.mean():.3g} A on average at positive speed and {lowering.mean():.3g} A at negative; "
            "friction makes it larger at positive speed, so its sign is likely the wrong one")


def _unsigned(drive: Stream) -> str:
    """Current and torque of the same messages: one that is told without its sign, or not below zero."""
    current, torque = drive.column("current"), drive.column("torque")
    known = np.isfinite(current)
    brakes, drives = known & (torque < _BRAKES), known & (torque > -_BRAKES)
    if (min(brakes.sum(), drives.sum()) < _LEAST or np.mean(current[brakes] > _NO_CURRENT) < _MOSTLY
            or np.mean(current[drives] > -_NO_CURRENT) < _MOSTLY):
        return ""
    return (f"{{drive}}: current is {np.median(current[brakes]):.3g} A while torque is {np.median(torque[brakes]):.3g} N*m, and hardly "
            "ever below 0; it is likely told without its sign, so that what it says of a drive that brakes is wrong")


def _torque(on: dict[str, np.ndarray], rig: Rig) -> str:
    """Both pressures against the current that turns the pumps against them: their size, which neither payload nor zero errors change."""
    asked, torque, here = _turned(on, rig, on["pressure_piston_side"], on["pressure_rod_side"])
    if _correlation(asked, torque, here) < _GO_TOGETHER:
        return ""
    ratio = float(asked[here].std() / torque[here].std())
    if 1.0 / _TIMES < ratio < _TIMES:
        return ""
    return (f"{{hydraulic}}: while the shaft turns, the pressures ask for {ratio:.2g} times the torque that the current of {{drive}} makes "
            "with the pumps of {rig}; the pressures or the current are likely in another unit, or a decimal place is lost")


def _turned(on: dict[str, np.ndarray], rig: Rig, piston: np.ndarray, rod: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """N*m, (n,), that pressures of both sides, Pa, ask for and that the current makes, and where both are known of a shaft that turns."""
    speed, torque = on["speed"], rig["motor.torque_constant"] * on["current"]
    one, other = (pressure * rig[f"{pump}.displacement"] / (2.0 * math.pi) for pressure, pump in ((piston, "pump_1"), (rod, "pump_2")))
    lost = np.abs(one) * rig["pump_1.friction_pressure"] + np.abs(other) * rig["pump_2.friction_pressure"]
    asked = one - other + np.sign(speed) * lost
    return asked, torque, np.isfinite(asked + torque) & (np.abs(speed) > _TURNING)


def _pressures(on: dict[str, np.ndarray], recording: Recording, rig: Rig) -> str:
    """Which of two pressures carries the load, or whether that is another; not asked where some are missing, as those that are beyond a
    sensor's range."""
    known = np.isfinite(recording.hydraulic.column("pressure_piston_side") + recording.hydraulic.column("pressure_rod_side"))
    if known.mean() < _MOSTLY:
        return ""
    declared = rig.declaring(recording.rig.payload_mass if recording.rig is not None else None)
    record = declared.parameters[0]
    piston, rod, load = (float(x) for x in (piston_area(record), rod_side_area(record), load_force(0.5 * rig["cylinder.stroke"], record)))
    one, other = on["pressure_piston_side"], on["pressure_rod_side"]
    here = np.isfinite(one) & np.isfinite(other) & (np.abs(on["rod_velocity"]) > _MOVING)
    if here.sum() < _LEAST:
        return ""
    as_is, exchanged = (abs(float(np.mean(a[here] * piston - b[here] * rod)) - load) for a, b in ((one, other), (other, one)))
    if as_is < _BETTER * exchanged or as_is < 0.5 * load:
        return ""
    left, left_exchanged = (float(np.sqrt(np.mean((asked - torque)[turning] ** 2))) if turning.sum() >= _LEAST else math.nan
                            for asked, torque, turning in (_turned(on, rig, one, other), _turned(on, rig, other, one)))
    only = "{hydraulic}: pressure_piston_side and pressure_rod_side carry the load only if they are exchanged"
    if left > _BETTER_TURNED * left_exchanged:
        return f"{only}; their connectors are likely swapped"
    carries = carried(recording, rig)
    as_they_are = "" if math.isnan(carries) else f", about {carries:.0f} kg as they are"
    given = f"the {declared['load.payload_mass']:g} kg that are declared or assumed"
    if left_exchanged > _BETTER_TURNED * left:
        return (f"{{hydraulic}}: the pressures do not fit {given}, but fit the current that turns the pumps against them; was it another "
                f"payload{as_they_are}?")
    return f"{only}; either their connectors are swapped, or the payload is another than {given}{as_they_are}"


def _winding(recording: Recording) -> str:
    """Heat goes from a winding to its housing: one that stays colder than the housing is the other sensor."""
    winding, housing = (recording.temperatures.get(name) for name in ("motor_winding", "motor_housing"))
    if winding is None or housing is None or min(len(winding), len(housing)) < _LEAST:
        return ""
    axis = _axis(winding, housing)
    warmer = _resampled(winding, winding.fields[0], axis) - _resampled(housing, housing.fields[0], axis)
    warmer = warmer[np.isfinite(warmer)]
    if warmer.size < _LEAST or np.quantile(warmer, _MOSTLY) > -_COLDER:
        return ""
    return (f"{recording.namespace}/temperature/motor_winding is {-np.median(warmer):.0f} K colder than motor_housing most of the time, "
            "though the winding is what heats it; their sensors are likely exchanged")


def _odd(ratios: np.ndarray, most: float) -> float | None:
    """The middle one of ratios that should be 1, (n,); None where it is less than ``most`` off, they scatter or are too few."""
    if ratios.size < _LEAST:
        return None
    low, ratio, high = np.quantile(ratios, [0.25, 0.5, 0.75])
    return None if 1.0 / most < ratio < most or high - low > _SCATTER * abs(ratio) else float(ratio)


def _correlation(one: np.ndarray, other: np.ndarray, here: np.ndarray) -> float:
    """Of two channels where both have numbers, 0 where these are too few or do not vary."""
    here = here & np.isfinite(one) & np.isfinite(other)
    if here.sum() < _LEAST or one[here].std() == 0.0 or other[here].std() == 0.0:
        return 0.0
    return float(np.corrcoef(one[here], other[here])[0, 1])
