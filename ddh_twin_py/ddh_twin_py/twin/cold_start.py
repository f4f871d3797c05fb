"""Can the unit keep itself warm? A cold-soaked unit that does its duty as fast as the oil allows.

Controller rule: before each cycle the highest speed that the drive can hold in each direction
(`possible_speed`) caps the duty's command, until both full speeds are allowed.

Two rates: one cycle by the full free run (`cycle`) gives mean heats, flows and square of the
current; with these the thermal network alone goes on (`advance`) until an oil that decides
viscosity has changed by `OIL_BOUND`, or `LONGEST_STEP` has gone by; then the next cycle. The means
are extrapolated to the middle of what is to come from the two cycles before (Adams-Bashforth).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from threading import Event

import numpy as np

from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.physics.motor import CUT_BACK_FROM, RAD_PER_S_OF_RPM
from ddh_twin_py.physics.oil import STATED_FROM, ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import (
    END_WINDING,
    LINE_A,
    LINE_B,
    N,
    N_EDGES,
    N_SURFACES,
    N_WALLS,
    PUMP_1_OIL,
    PUMP_2_OIL,
    SLOT_WINDING,
    TANK,
    capacities,
    conductances,
    network_rates,
    network_step,
)
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.oil_grades import oil_grade
from ddh_twin_py.twin.cycle import DutyRun
from ddh_twin_py.twin.duty import Duty, DutyError, check_for_rig
from ddh_twin_py.twin.possible_speed import LIMITS, NOTHING, STEADY, highest_speed

OIL_BOUND = 1.5
"""K by which the oil in pumps and lines may change between two simulated cycles."""
WINDING_BOUND = 15.0
"""K by which a winding may."""
LONGEST_STEP = 1800.0
"""s between two simulated cycles at most."""
LONGEST_CYCLE = 900.0
"""s of one simulated cycle; a stroke that creeps longer is cut there and goes on in the next."""
SLOWEST = 5.0 * RAD_PER_S_OF_RPM
"""rad/s below which the unit counts as stuck."""
GROWTH = 0.3
"""A step between two simulated cycles is at most this share of the time gone by."""
TRIP = CUT_BACK_FROM
"""K of winding at which a run ends: the drive trips."""
LOOK_AHEAD = 1.25
"""Speeds are looked for up to this multiple of the full speed, to tell when the full speed became allowed."""
SETTLED_RATE = 0.5
"""K/h of tank oil and winding below which a run counts as settled."""
_NETWORK_STEP = 5.0  # s
_ORDER = 2

VERDICTS = ("full at once", "reaches full speed", "stays slow", "stuck", "overheats")
"""What becomes of a start. `overheats` goes before the others: the winding passes its limit at some time."""


@kernel
def advance(params, began, average, temperature, ambient, heat, square, flow, ahead, position, duration, bound, longest, step):
    """Go on from one simulated cycle with the thermal network alone; in place on ``temperature``.

    The network runs from the cycle's mean temperatures under its mean heats and flows, with what
    these miss as a constant heat: C_i (T_i(end) - T_i(start))/duration less the network's own rate
    at the means. That is how the means of flow times temperature differ from the product of the
    means where oil goes to and fro. What the end of the cycle differs from its mean is kept.

    Args:
        began, average, temperature: at the start of the cycle, its mean, at its end, K, (N,).
        ambient: K. heat: W per node without copper, (N,). square: mean square of the current, A^2.
        flow: m3/s. ahead: heat, flow and square that are expected in the time to come, one after the other.
        position: m, mean of the rod. duration: s, of the cycle.
        bound: K per node, (N,), by which it may change. longest: s. step: s.
    Returns:
        s gone by, at least one step.
    """
    p = params[0]
    edge, wall, surface = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3))
    capacity, work, rate = np.empty(N), np.empty((N + 3, N)), np.empty(N)
    conductances(params, edge, wall, surface)
    capacities(params, position, capacity)
    air = ambient + p.surroundings_enclosure_rise
    network_rates(params, edge, wall, surface, capacity, average, air, heat, square, flow, rate)
    whole = ahead[:N] + capacity * ((temperature - began) / duration - rate)
    flow_ahead, square_ahead = ahead[N:-1], ahead[-1]
    moved = average.copy()
    count = max(1, int(np.ceil(longest / step)))
    step = longest / count
    gone = 0.0
    for _ in range(count):
        network_step(params, edge, wall, surface, capacity, moved, air, whole, square_ahead, flow_ahead, step, work)
        gone += step
        far = False
        for i in range(N):
            far = far or abs(moved[i] - average[i]) >= bound[i]
        if far:
            break
    for i in range(N):
        temperature[i] += moved[i] - average[i]
    return gone


@dataclass(frozen=True)
class Case:
    """One start: ambient in degC, name of the oil grade, name of the duty."""

    ambient: float
    grade: str
    duty: str


@dataclass(frozen=True)
class Outcome:
    """What became of a start; temperatures in degC, times in s, speeds as shares of the duty's full speed.

    Attributes:
        verdict: one of `VERDICTS`. slow: full speed is not allowed at the end.
        first_raise, first_lower: share of the full speed that is allowed at the start.
        first_limit: what forbids more at the start, one of `possible_speed.LIMITS`.
        final_share: the lower of both shares at the end. final_limit: what forbids more then.
        time_to_full: until both full speeds are allowed; NaN: never within the time.
        tank_oil, pump_oil, winding: at the end of the run, the winding's peak within the last cycle.
        winding_peak: highest of the whole run. time_over_limit: when the winding passed its limit, NaN: never.
        settled: tank oil and winding change by less than `SETTLED_RATE` at the end.
        viscosity: mm2/s of the oil at the start. extrapolated: the Walther law is left at the start.
        cavitating: largest share of a cycle in which a port or chamber is at the vapour pressure: the rule looks at
            what a speed settles to, at the start of a stroke a pressure can dip further.
        cycles: simulated by the full free run. time, history: s and K, (k,) and (k, N), after each step.
        share: of the full speed at these times, (k,).
    """

    case: Case
    verdict: str
    slow: bool
    first_raise: float
    first_lower: float
    first_limit: str
    final_share: float
    final_limit: str
    time_to_full: float
    tank_oil: float
    pump_oil: float
    winding: float
    winding_peak: float
    time_over_limit: float
    settled: bool
    viscosity: float
    extrapolated: bool
    cavitating: float
    cycles: int
    time: np.ndarray
    share: np.ndarray
    history: np.ndarray


def check_moves(duty: Duty) -> None:
    """Whether a duty moves at all.

    Raises:
        DutyError: for one that only stands; a share of its speed says nothing.
    """
    if not any(segment.kind != "dwell" and segment.speed != 0.0 for segment in duty.cycle):
        raise DutyError(f"{duty.file}: cycle: nothing moves, at least one segment with a speed_rpm other than 0 is needed")


class AllowedSpeed:
    """The controller's rule for a duty: caps of the command from the temperatures.

    Attributes:
        full: rad/s, the lower of the duty's highest speeds in both directions.
    """

    def __init__(self, rig: Rig, duty: Duty) -> None:
        self._parameters = rig.parameters
        speeds = {"lift": [0.0], "lower": [0.0]}
        for segment in duty.cycle:
            if segment.kind in ("lift", "position") or segment.kind == "speed" and segment.speed > 0.0:
                speeds["lift"].append(abs(segment.speed))
            if segment.kind in ("lower", "position") or segment.kind == "speed" and segment.speed < 0.0:
                speeds["lower"].append(abs(segment.speed))
        self._full = max(speeds["lift"]), max(speeds["lower"])
        self.full = min(full for full in self._full if full > 0.0)
        self._ramp = duty.ramp
        self._out = np.empty(len(STEADY))

    def shares(self, temperature: np.ndarray) -> tuple[tuple[float, float], tuple[str, str]]:
        """Allowed shares of the full speed, raising and lowering, up to `LOOK_AHEAD`, and what forbids more."""
        found = [
            highest_speed(self._parameters, temperature, sign, LOOK_AHEAD * full, self._ramp, self._out) if full > 0.0
            else (np.inf, NOTHING)
            for sign, full in zip((1.0, -1.0), self._full, strict=True)
        ]
        shares = [speed / full if full > 0.0 else LOOK_AHEAD for (speed, _), full in zip(found, self._full, strict=True)]
        return tuple(shares), tuple(LIMITS[reason] for _, reason in found)

    def caps(self, shares: tuple[float, float]) -> tuple[float, float]:
        """Lowest and highest command, rad/s."""
        up, down = (min(share, 1.0) * full for share, full in zip(shares, self._full, strict=True))
        return -down, up


def start(rig: Rig, duty: Duty, case: Case, hours: float, oil_bound: float = OIL_BOUND, stop: Event | None = None) -> Outcome:
    """Run one start.

    Args:
        rig: its oil is replaced by the case's grade, its payload by the duty's. hours: how long.
        stop: once set, the run ends after the cycle that it is at and raises CancelledError.

    Raises:
        RigError, DutyError: for an oil grade that is not known, a duty beyond the stroke or without motion.
    """
    check_moves(duty)
    check_for_rig(duty, rig)
    grade = oil_grade(case.grade)
    filled = rig.with_oil(case.grade).declaring(duty.payload)
    ambient = case.ambient + ZERO_CELSIUS
    run = DutyRun(filled, duty, ambient, ambient, patient=True)
    rule = AllowedSpeed(filled, duty)
    limit = filled["motor.thermal.winding_limit"] + ZERO_CELSIUS
    bound = np.full(N, np.inf)
    bound[[PUMP_1_OIL, PUMP_2_OIL, LINE_A, LINE_B]] = oil_bound
    bound[[SLOT_WINDING, END_WINDING]] = WINDING_BOUND
    horizon = 3600.0 * hours
    now, cycles, before, last_step = 0.0, 0, None, 0.0
    time, share, history = [0.0], [], [run.temperature.copy()]
    time_to_full, over, peak, cavitating = np.nan, np.nan, -np.inf, 0.0
    shares, limits = rule.shares(run.temperature)
    first, first_limits = shares, limits
    while True:
        least = min(shares)
        if np.isnan(time_to_full) and least >= 1.0:
            time_to_full = _crossing(time, share[-1], least) if share else 0.0
        share.append(min(least, 1.0))
        if least * rule.full < SLOWEST or now >= horizon or peak >= TRIP:
            break
        if stop is not None and stop.is_set():
            raise CancelledError
        began = run.temperature.copy()
        one = run.cycle(*rule.caps(shares), longest=LONGEST_CYCLE)
        cycles += 1
        mean = one.mean[0]
        cavitating = max(cavitating, one.extremes["cavitating"])
        now += one.duration
        top = one.extremes["winding"]
        ahead = min(LONGEST_STEP, horizon - now, GROWTH * now)
        if ahead > 0.0:
            at_end = run.temperature[[SLOT_WINDING, END_WINDING]].max()
            means = np.concatenate([mean["heat"], mean["flow"], [mean["mean_square_current"]]])
            middle = now - 0.5 * one.duration
            used = means if before is None else _extrapolated(means, middle, *before, min(ahead, last_step))
            last_step = advance(
                run.parameters, began, one.average, run.temperature, ambient, mean["heat"], mean["mean_square_current"],
                mean["flow"], used, mean["rod_position"], one.duration, bound, ahead, min(_NETWORK_STEP, ahead),
            )
            now += last_step
            before = (means, middle)
            top += max(0.0, float(run.temperature[[SLOT_WINDING, END_WINDING]].max() - at_end))
        if np.isnan(over) and top > limit:
            over = _passing(time[-1], now, max(peak, ambient), top, limit)
        peak = max(peak, top)
        time.append(now)
        history.append(run.temperature.copy())
        shares, limits = rule.shares(run.temperature)
    last = history[-1]
    final = min(shares)
    slow = final < 1.0
    winding = top if cycles else ambient
    verdict = (
        "overheats" if np.isfinite(over) else "stuck" if final * rule.full < SLOWEST else "stays slow" if slow
        else "full at once" if time_to_full == 0.0 else "reaches full speed"
    )
    return Outcome(
        case, verdict, slow, min(first[0], 1.0), min(first[1], 1.0), _binding(first, first_limits), min(final, 1.0),
        _binding(shares, limits), float(time_to_full), last[TANK] - ZERO_CELSIUS,
        0.5 * (last[PUMP_1_OIL] + last[PUMP_2_OIL]) - ZERO_CELSIUS, winding - ZERO_CELSIUS,
        max(peak, ambient) - ZERO_CELSIUS, float(over), _settled(time, history), grade.viscosity(case.ambient),
        case.ambient + ZERO_CELSIUS < STATED_FROM, float(cavitating), cycles, np.array(time), np.array(share), np.array(history),
    )


def sweep(rig: Rig, duties: dict[str, Duty], cases: Sequence[Case], hours: float,
          progress: Callable[[float], None] | None = None, workers: int | None = None) -> list[Outcome]:
    """Every case, in their order; several at a time, since the compiled parts run beside each other."""
    outcomes: list[Outcome | None] = [None] * len(cases)
    stop = Event()
    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
        waiting = {pool.submit(start, rig, duties[case.duty], case, hours, stop=stop): i for i, case in enumerate(cases)}
        try:
            for done, future in enumerate(as_completed(waiting), 1):
                outcomes[waiting[future]] = future.result()
                if progress is not None:
                    progress(done / len(cases))
        except BaseException:
            stop.set()
            pool.shutdown(cancel_futures=True)
            raise
    return outcomes


def _extrapolated(means: np.ndarray, middle: float, earlier: np.ndarray, earlier_middle: float, ahead: float) -> np.ndarray:
    """Means in the middle of the step to come, linear through the last two cycles; none changes its sign or more than doubles."""
    change = (means - earlier) * (0.5 * ahead / (middle - earlier_middle))
    return np.where(means >= 0.0, np.clip(means + change, 0.0, 2.0 * means), np.clip(means + change, 2.0 * means, 0.0))


def _crossing(time: Sequence[float], before: float, now: float) -> float:
    """When the allowed share passed 1 within the last step, s, linear between its ends."""
    part = (1.0 - before) / (now - before) if now > before else 1.0
    return time[-2] + part * (time[-1] - time[-2])


def _passing(start_time: float, end_time: float, before: float, after: float, limit: float) -> float:
    part = (limit - before) / (after - before) if after > before else 1.0
    return start_time + min(max(part, 0.0), 1.0) * (end_time - start_time)


def _binding(shares: tuple[float, float], limits: tuple[str, str]) -> str:
    worst = int(np.argmin(shares))
    return limits[worst] if shares[worst] < 1.0 else LIMITS[NOTHING]


def _settled(time: Sequence[float], history: Sequence[np.ndarray]) -> bool:
    """Whether tank oil and windings changed by less than `SETTLED_RATE` over the last steps."""
    if len(time) <= _ORDER:
        return True
    nodes = [TANK, SLOT_WINDING, END_WINDING]
    k = next((i for i in range(len(time) - 1, -1, -1) if time[-1] - time[i] >= 1800.0), 0)
    rate = np.abs(history[-1][nodes] - history[k][nodes]) / (time[-1] - time[k]) * 3600.0
    return bool(np.all(rate < SETTLED_RATE))
