"""Duty files: what a rig is asked to do, as speed or position commands with payload and ambient.

A duty file is YAML:

    payload_kg: 149.5
    ambient_degC: 23.0            # or a list of [time_s, degC]
    start_position_m: 0.01
    ramp_rpm_per_s: 1150          # how fast the command may change
    repeat: 20                    # times the cycle is run; 0: for ever
    cycle:
      - lift: {speed_rpm: 500, to_m: 0.39}
      - dwell: {duration_s: 3}
      - lower: {speed_rpm: 500, to_m: 0.01}
      - speed: {speed_rpm: -200, duration_s: 2}       # a plain speed command
      - position: {to_m: 0.2, speed_rpm: 300}         # go there from either side
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.names import cited, nearest
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.rig import LARGEST_PAYLOAD, Rig
from ddh_twin_py.rig.numbers import finite_number
from ddh_twin_py.rig.yaml_file import LARGEST_FILE, mapping, parse_yaml, read_yaml, shown
from ddh_twin_py.twin.duty_program import COMMAND, CYCLES, KINDS, new_program, next_command

_SEGMENTS = {
    "lift": ({"speed_rpm", "to_m"}, {"timeout_s"}),
    "lower": ({"speed_rpm", "to_m"}, {"timeout_s"}),
    "position": ({"speed_rpm", "to_m"}, {"timeout_s"}),
    "speed": ({"speed_rpm", "duration_s"}, set()),
    "dwell": ({"duration_s"}, set()),
}
_TOP = {"payload_kg", "ambient_degC", "start_position_m", "ramp_rpm_per_s", "repeat", "cycle"}
_TIMEOUT = 60.0
_AMBIENT = (-60.0, 80.0)  # degC
_POSITION = (0.0, 2.0)  # m, of any rig; `check_for_rig` knows the stroke
_SPEED = 6000.0  # rpm
_RAMP = (1.0, 1.0e6)  # rpm/s
_LONGEST = 1.0e7  # s


class DutyError(ValueError):
    """A duty file that cannot be used; the message names file, entry and value."""


@dataclass(frozen=True)
class Segment:
    """One part of the cycle: kind, speed in rad/s (not signed but for ``speed``), goal in m, duration or time-out in s."""

    kind: str
    speed: float
    goal: float
    duration: float


@dataclass(frozen=True)
class Duty:
    """What the rig is asked to do.

    Attributes:
        payload: kg. ambient: times (s) and temperatures (K), each (k,). start_position: m.
        ramp: rad/s2. repeat: times, 0 is for ever. cycle: the segments. file: where it was read from.
    """

    payload: float
    ambient_time: np.ndarray
    ambient: np.ndarray
    start_position: float
    ramp: float
    repeat: int
    cycle: tuple[Segment, ...]
    file: str = "duty"


def load_duty(path: str | Path) -> Duty:
    """Read a duty file.

    Raises:
        DutyError: file missing or not YAML, an entry given twice or unknown (with the nearest valid one), a
            value that is no number or out of range.
    """
    path = Path(path)
    return duty_of(read_yaml(path, "duty file", DutyError), path)


def parse_duty(text: str, name: str = "duty") -> Duty:
    """A duty from the text of a duty file; see `load_duty`."""
    if len(text) > LARGEST_FILE:
        raise DutyError(f"{name}: has {len(text)} characters, allowed are {LARGEST_FILE}")
    return duty_of(parse_yaml(text, name, DutyError), Path(name))


def duty_of(tree: object, path: Path) -> Duty:
    """The duty that a parsed file holds; ``path`` names it in errors.

    Raises:
        DutyError: see `load_duty`.
    """
    tree = mapping(tree, str(path), "duty file", DutyError)
    _known(path, "", tree, _TOP)
    cycle = tree.get("cycle")
    if not isinstance(cycle, list) or not cycle:
        raise DutyError(f"{path}: cycle: found {shown(cycle)}, a list of segments is needed")
    ambient = tree.get("ambient_degC", 23.0)
    rows = ambient if isinstance(ambient, list) else [[0.0, ambient]]
    if not rows or not all(isinstance(row, list) and len(row) == 2 for row in rows):
        raise DutyError(f"{path}: ambient_degC: found {cited(ambient)}, a number or a list of [time_s, degC] is needed")
    table = np.array([
        (_number(path, "ambient_degC time", when), _between(path, "ambient_degC", degc, *_AMBIENT, "degC")) for when, degc in rows
    ])
    if np.any(np.diff(table[:, 0]) <= 0.0):
        raise DutyError(f"{path}: ambient_degC: times must rise, found {cited(table[:, 0].tolist())}")
    return Duty(
        payload=_between(path, "payload_kg", tree.get("payload_kg", 149.5), 1e-3, LARGEST_PAYLOAD, "kg"),
        ambient_time=table[:, 0],
        ambient=table[:, 1] + 273.15,
        start_position=_between(path, "start_position_m", tree.get("start_position_m", 0.01), *_POSITION, "m"),
        ramp=_between(path, "ramp_rpm_per_s", tree.get("ramp_rpm_per_s", 1150.0), *_RAMP, "rpm/s") * RAD_PER_S_OF_RPM,
        repeat=_count(path, "repeat", tree.get("repeat", 1)),
        cycle=tuple(_segment(path, i, row) for i, row in enumerate(cycle)),
        file=str(path),
    )


def check_duration(duration: float | None, of: str) -> None:
    """Whether a run can be so many s long; None: as long as its duty.

    Raises:
        DutyError: it cannot.
    """
    if duration is not None and not 0.0 < duration < math.inf:
        raise DutyError(f"the duration of the {of} is {duration:g} s, it must be above 0")


def check_for_rig(duty: Duty, rig: Rig) -> None:
    """Whether the rig can do the duty at all.

    Raises:
        DutyError: for a position that is not within the rig's stroke.
    """
    stroke = rig["cylinder.stroke"]
    wanted = [("start_position_m", duty.start_position)]
    wanted += [
        (f"cycle[{i}].{segment.kind}.to_m", segment.goal)
        for i, segment in enumerate(duty.cycle) if segment.kind not in ("speed", "dwell")
    ]
    for name, position in wanted:
        if not 0.0 <= position <= stroke:
            raise DutyError(f"{duty.file}: {name}: value is {position:g} m, allowed are 0 to {stroke:g} m, the stroke of {rig.file}")


def _known(path: Path, where: str, tree: dict, valid: set[str]) -> None:
    for key in tree:
        if key not in valid:
            raise DutyError(f"{path}: {where}{key}: no such entry{nearest(key, sorted(valid))}")


def _number(path: Path, name: str, value: object) -> float:
    return finite_number(f"{path}: {name}", value, DutyError)


def _between(path: Path, name: str, value: object, lowest: float, highest: float, unit: str) -> float:
    number = _number(path, name, value)
    if not lowest <= number <= highest:
        raise DutyError(f"{path}: {name}: value is {number:g} {unit}, allowed are {lowest:g} to {highest:g} {unit}")
    return number


def _count(path: Path, name: str, value: object) -> int:
    number = _number(path, name, value)
    if number < 0.0 or number != int(number):
        raise DutyError(f"{path}: {name}: value is {cited(value)}, a whole number from 0 on is needed (0: for ever)")
    return int(number)


def _segment(path: Path, index: int, row: object) -> Segment:
    where = f"cycle[{index}]"
    if not isinstance(row, dict) or len(row) != 1:
        raise DutyError(f"{path}: {where}: found {shown(row)}, one of {', '.join(_SEGMENTS)} with its values is needed")
    (kind, values), = row.items()
    _known(path, f"{where}.", {kind: None}, set(_SEGMENTS))
    needed, optional = _SEGMENTS[kind]
    if not isinstance(values, dict):
        raise DutyError(f"{path}: {where}.{kind}: found {shown(values)}, needed are {', '.join(sorted(needed))}")
    _known(path, f"{where}.{kind}.", values, needed | optional)
    for name in sorted(needed - set(values)):
        raise DutyError(f"{path}: {where}.{kind}: {name} is missing")
    number = {name: _number(path, f"{where}.{kind}.{name}", value) for name, value in values.items()}
    if "speed_rpm" in number:
        _between(path, f"{where}.{kind}.speed_rpm", number["speed_rpm"], -_SPEED, _SPEED, "rpm")
    if "to_m" in number:
        _between(path, f"{where}.{kind}.to_m", number["to_m"], *_POSITION, "m")
    speed = number.get("speed_rpm", 0.0) * RAD_PER_S_OF_RPM
    if kind != "speed" and kind != "dwell" and speed <= 0.0:
        raise DutyError(f"{path}: {where}.{kind}.speed_rpm: value is {values['speed_rpm']}, it must be above 0")
    duration = number.get("duration_s", number.get("timeout_s", _TIMEOUT))
    if not 0.0 < duration <= _LONGEST:
        raise DutyError(f"{path}: {where}.{kind}: a duration of {duration:g} s; it must be above 0 and at most {_LONGEST:g} s")
    return Segment(kind, speed, number.get("to_m", 0.0), duration)


def segment_table(duty: Duty) -> np.ndarray:
    """The cycle as `duty_program.next_command` takes it, shape (k, 4)."""
    return np.array([(KINDS.index(s.kind), s.speed, s.goal, s.duration) for s in duty.cycle])


class DutyCommand:
    """Turns a duty into a speed command, given where the rod is."""

    def __init__(self, duty: Duty) -> None:
        self._duty = duty
        self._segments = segment_table(duty)
        self._program = new_program()
        self.finished = False

    @property
    def command(self) -> float:
        """rad/s, now."""
        return float(self._program[COMMAND])

    def step(self, position: float, rod_speed_per_rad: float, period: float) -> float:
        """Command for the next control period, rad/s.

        Args:
            position: m. rod_speed_per_rad: m of rod per rad of shaft, to brake in time.
            period: s.
        """
        ramp = self._duty.ramp
        if self.finished:
            self._program[COMMAND] -= min(max(self.command, -ramp * period), ramp * period)
            return self.command
        command = next_command(self._segments, ramp, -np.inf, np.inf, self._program, position, rod_speed_per_rad, period)
        self.finished = 0 < self._duty.repeat <= self._program[CYCLES]
        return float(command)
