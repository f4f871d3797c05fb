"""The compiled part of screening: one pass over samples in order of arrival, state carried over.

All state lies in arrays, so that a chunk of one sample and a whole recording are the same call.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.physics.compiled import inlined, kernel
from ddh_twin_py.telemetry.causes import Cause
from ddh_twin_py.telemetry.clocks.clock import BEGAN, CLOCK_ENTRIES, ENDED, JUMPS, LEFT, NEVER, NEWEST, RETURNS, clock_begin, clock_step

NAN, INF, RANGE, UNIT, STUCK = 1, 2, 4, 8, 16
REPEATED, LATE, JUMP, GAP, SATURATED = 32, 64, 128, 256, 512
assert (NAN, INF, RANGE, UNIT, STUCK) == (1, 2, Cause.OUT_OF_RANGE, Cause.WRONG_UNIT, Cause.STUCK)
assert (REPEATED, LATE, JUMP, GAP) == (Cause.REPEATED, Cause.OUT_OF_ORDER, Cause.CLOCK_JUMP, Cause.GAP)
assert SATURATED == Cause.SATURATED
CAUSES = 10

# columns of `field_state` float64[m, FIELD_COLUMNS]
LAST, RUN, RUN_SINCE, QUANTUM, CHANGES, SAMPLES, STUCK_LIMIT = range(7)
FIELD_COLUMNS = 7

# entries of `stream_state` int64[STREAM_ENTRIES], behind those of its clock
COUNT, SEGMENT, PERIOD, PERIODS, RING_AT, RING_FULL = range(CLOCK_ENTRIES, CLOCK_ENTRIES + 6)
STREAM_ENTRIES = CLOCK_ENTRIES + 6

RING = 1024  # stamps remembered to recognise a late repetition
FIRST_PERIODS = 16  # intervals of which the median is the first typical period

GAP_PERIODS = 10  # a stream has stopped after this many typical periods without a sample
FALSE_ALARM = 1e-12  # chance that a sound sensor repeats so long, per run
LEAST_RUN = 20  # samples
UNSEEN_QUANTUM = 3.0  # in standard deviations of the noise, while a value never changed
UNSEEN_TIME = 10_000_000_000  # ns, least length of a run while a value never changed
SEEN_TIME = 1_000_000_000  # ns, least length of a run otherwise
ALIVE = 20.0  # in standard deviations: another field this far from zero says the machine is at work

HEATS = 10.0  # K from the sample before, within which a place that leaves its range first got there by heat, and by no unit

# kinds of unit rules and columns of `rule_state` float64[r, RULE_COLUMNS]
SMALL, RATIO = 0, 1
WINDOW = 5  # column of `rules`, whether a rule makes windows
RULE_COUNT, RULE_A, RULE_B, RULE_C = range(4)
RULE_COLUMNS = 4
EVIDENCE = 200  # samples of a rule's condition that make a window


@inlined
def _run_limit(quantum, noise):  # pragma: no cover - compiled
    """Longest run of equal values that a sensor with noise and quantum can be trusted with.

    A value quantised in steps q repeats with probability p <= erf(q / (2 sqrt(2) sigma)).
    """
    p = math.erf(quantum / (2.0 * math.sqrt(2.0) * noise))
    if p >= 1.0:
        return np.inf
    if p <= 0.0:
        return float(LEAST_RUN)
    return max(float(LEAST_RUN), math.ceil(math.log(FALSE_ALARM) / math.log(p)))


@inlined
def _note(counts, first, first_value, cause, field, stamp, value):  # pragma: no cover - compiled
    if counts[cause, field] == 0:
        first[cause, field] = stamp
        first_value[cause, field] = value
    counts[cause, field] += 1


@inlined
def _known(ring, stream, stamp):  # pragma: no cover - compiled
    entries = RING if stream[RING_FULL] else stream[RING_AT]
    for i in range(entries):
        if ring[i] == stamp:
            return True
    return False


@inlined
def _learn_period(stream, periods, step):  # pragma: no cover - compiled
    """Typical interval between samples: median of the first ones, then adapted slowly."""
    n = stream[PERIODS]
    if n < FIRST_PERIODS:
        while n > 0 and periods[n - 1] > step:  # kept sorted
            periods[n] = periods[n - 1]
            n -= 1
        periods[n] = step
        stream[PERIODS] += 1
        stream[PERIOD] = periods[stream[PERIODS] // 2]
    elif step > stream[PERIOD]:
        stream[PERIOD] += stream[PERIOD] // 512 + 1
    else:
        stream[PERIOD] -= stream[PERIOD] // 512


@inlined
def _judge_time(stamp, stream, ring, periods, window):  # pragma: no cover - compiled
    """Flag of one stamp; the interval in ns is the second value where there is one, of a jump by how much the clock was set back."""
    if stream[COUNT] == 0:
        clock_begin(stamp, stream)
        return 0, 0
    newest, left = stream[NEWEST], stream[LEFT]
    does = clock_step(stamp, stream, window)
    if does == JUMPS:
        stream[SEGMENT] += 1
        stream[RING_AT] = 0
        stream[RING_FULL] = 0
        return JUMP, newest - stamp + stream[PERIOD]
    step = stamp - (left if does == RETURNS else newest)
    known, longest = stream[PERIODS] == FIRST_PERIODS, max(GAP_PERIODS * stream[PERIOD], window)
    if stream[LEFT] != NEVER and step > 0 and known and stamp - stream[LEFT] > longest:
        return LATE, stream[ENDED] + stream[PERIOD] + stream[LEFT] - stream[BEGAN] - stamp  # of the time before the clock jumped
    if step > 0:
        _learn_period(stream, periods, step)
        return (GAP if known and step > longest else 0), step
    if step == 0:
        return REPEATED, 0
    return (REPEATED if _known(ring, stream, stamp) else LATE), -step


@inlined
def _judge_run(value, field, noise, scale_alive, stamp, field_state):  # pragma: no cover - compiled
    """Whether a field repeats one value for longer than its noise allows."""
    state = field_state[field]
    state[SAMPLES] += 1.0
    if value != state[LAST]:
        if state[LAST] == state[LAST]:
            step = abs(value - state[LAST])
            if not state[QUANTUM] <= step:
                state[QUANTUM] = step
                state[STUCK_LIMIT] = _run_limit(step, noise)
            state[CHANGES] += 1.0
        state[LAST] = value
        state[RUN] = 1.0
        state[RUN_SINCE] = stamp
        return False
    if value == 0.0 and not scale_alive:
        state[SAMPLES] -= 1.0
        return False  # a drive that is switched off reads exactly zero
    state[RUN] += 1.0
    if state[CHANGES] == 0.0:
        limit = _run_limit(UNSEEN_QUANTUM * noise, noise)
        least = UNSEEN_TIME
    else:
        held = max(1.0, (state[SAMPLES] - state[RUN]) / state[CHANGES])
        limit = state[STUCK_LIMIT] * held
        least = SEEN_TIME
    return state[RUN] > limit and stamp - state[RUN_SINCE] > least


@kernel
def screen(
    stamp,
    values,
    limits,
    full_scale,
    noise,
    rules,
    floors,
    mistakes,
    stream,
    ring,
    periods,
    field_state,
    suspect,
    mistaken,
    reached,
    rule_state,
    counts,
    first,
    first_value,
    flags,
    window,
    begin,
    needed,
):  # pragma: no cover - compiled
    """Judge samples in order of arrival; values that are not believed become NaN in place.

    Begins with sample `begin` and returns where it stopped: at the end, or once a unit rule
    that makes windows has the `needed` samples of evidence.

    stamp int64[n]; values float64[n, c]; limits float64[m, 2]; full_scale float64[m], of the
    sensors (inf: not known); noise float64[m] (0: none);
    rules int64[r, 6], floors float64[r]: see `unit_rules`; mistakes float64[m, k, 5]: factor
    and offset of usual mistakes of unit, between what the right value is, and how large it must
    be once; suspect bool[m]: fields held to be in a wrong unit; mistaken bool[m, k]: mistakes that
    explain all values out of range, reached bool[m, k]: of which one is that large; the rest is
    state and counts; flags uint16[n, m] is written.
    """
    fields = limits.shape[0]
    raw = np.empty(fields)
    for i in range(begin, stamp.size):
        flag, step = _judge_time(stamp[i], stream, ring, periods, window)
        stream[COUNT] += 1
        if flag:
            cause = 6 if flag == REPEATED else 7 if flag == LATE else 8 if flag == JUMP else 9
            _note(counts, first, first_value, cause, 0, stamp[i], step * 1e-9)
        if flag == JUMP:
            for j in range(fields):
                field_state[j, LAST] = np.nan
                field_state[j, RUN] = 0.0
        if flag == REPEATED:
            for j in range(fields):
                flags[i, j] = flag
            continue
        ring[stream[RING_AT]] = stamp[i]
        stream[RING_AT] += 1
        if stream[RING_AT] == RING:
            stream[RING_AT] = 0
            stream[RING_FULL] = 1
        alive = 0
        for j in range(fields):
            if noise[j] > 0.0 and abs(values[i, j]) > ALIVE * noise[j]:
                alive += 1
        for j in range(fields):
            value = values[i, j]
            raw[j] = value
            own = 0
            if value != value:
                own = NAN
                _note(counts, first, first_value, 0, j, stamp[i], value)
            elif abs(value) == np.inf:
                own = INF
                _note(counts, first, first_value, 1, j, stamp[i], value)
            elif value < limits[j, 0] or value > limits[j, 1]:
                own = RANGE
                _note(counts, first, first_value, 2, j, stamp[i], value)
                heated = counts[2, j] == 1 and abs(value - field_state[j, LAST]) < HEATS
                for k in range(mistakes.shape[1]):
                    right = (value - mistakes[j, k, 1]) / mistakes[j, k, 0]
                    if not mistakes[j, k, 2] <= right <= mistakes[j, k, 3] or (
                            heated and mistakes[j, k, 0] > 1.0 and mistakes[j, k, 1] != 0.0):  # a unit of temperature with smaller degrees
                        mistaken[j, k] = False
                    if abs(right) >= mistakes[j, k, 4]:
                        reached[j, k] = True
            elif abs(value) >= full_scale[j]:
                own = SATURATED
                _note(counts, first, first_value, 5, j, stamp[i], value)
            else:
                if suspect[j]:
                    own |= UNIT
                    _note(counts, first, first_value, 3, j, stamp[i], value)
                if noise[j] > 0.0 and flag != LATE:
                    others = alive - (1 if abs(value) > ALIVE * noise[j] else 0)
                    if _judge_run(value, j, noise[j], others > 0, stamp[i], field_state):
                        own |= STUCK
                        raw[j] = np.nan  # no evidence of a unit
                        _note(counts, first, first_value, 4, j, stamp[i], value)
            if own:
                values[i, j] = np.nan
            flags[i, j] = own | flag
        complete = False
        for r in range(rules.shape[0]):
            _gather_evidence(raw, rules[r], floors[r], rule_state[r])
            complete |= rules[r, WINDOW] > 0 and rule_state[r, RULE_COUNT] >= needed
        if complete:
            return i + 1
    return stamp.size


@inlined
def _gather_evidence(row, rule, floor, state):  # pragma: no cover - compiled
    """Add one sample to the evidence of one unit rule, where its condition holds."""
    a, b, c, d = rule[1], rule[2], rule[3], rule[4]
    if rule[0] == SMALL:  # largest |a|, and the sum of a, while |c| is above the floor
        if abs(row[c]) > floor and abs(row[a]) < np.inf:
            state[RULE_COUNT] += 1.0
            state[RULE_A] = max(state[RULE_A], abs(row[a]))
            state[RULE_B] += row[a]
    else:  # |a|, what it is held against: b * c, or |b| where there is no c, and d squared, summed while that is above the floor
        against = row[b] * row[c] if c >= 0 else abs(row[b])
        if floor < against < np.inf and abs(row[a]) < np.inf:
            state[RULE_COUNT] += 1.0
            state[RULE_A] += abs(row[a])
            state[RULE_B] += against
            if d >= 0 and abs(row[d]) < np.inf:
                state[RULE_C] += row[d] * row[d]
