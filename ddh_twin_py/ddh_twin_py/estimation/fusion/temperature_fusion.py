"""Temperatures of the whole unit from both models and whichever sensors there are.

Give it, interval by interval, the heat and flows of the models and the readings that came in;
it answers with every node's temperature and standard deviation. Nothing is required: without
sensors it is the models' prediction with the uncertainty of the sheet, without models it is
the sensors with the uncertainty of unknown heat.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from ddh_twin_py.estimation.fusion.covariance_prediction import predict_covariance
from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading, Readings, air_of
from ddh_twin_py.estimation.fusion.left_together import Departures, LeftTogether
from ddh_twin_py.estimation.fusion.outvoted import COLDER, HEARD, colder_than_all, outvoted, told_outvoted
from ddh_twin_py.estimation.fusion.result import FusionResult, Innovation
from ddh_twin_py.estimation.fusion.smoother import SMOOTHED_EVERY, Trace
from ddh_twin_py.estimation.fusion.state import FusionState, start_covariance
from ddh_twin_py.estimation.fusion.temperature_filter import NEVER_READ, advance_mean, update
from ddh_twin_py.estimation.fusion.uncertain_parameters import AMBIENT_AT, COPPER_AT, N_UNCERTAIN, UNKNOWN_HEAT_AT, uncertain_parameters
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, N, N_FLOWS, NODES, capacities
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.ambient import AmbientTracker
from ddh_twin_py.twin.intervals import INTERVAL
from ddh_twin_py.twin.sensor_errors import sensor_lags, temperature_noise, temperature_zero_errors
from ddh_twin_py.twin.temperature_sensors import all_sensed

EPOCH = 1.0
"""s between two steps of the covariance."""
UNKNOWN_AMBIENT = 10.0
"""K, standard deviation of the air where no sensor tells it."""
_M = len(SENSORS)
_GROUPS = slice(0, len(MOTOR_NODES)), slice(len(MOTOR_NODES), N)  # nodes of which the one and the other model tells the heat

# W, heat of a node that may be running unseen before anything is known of its duty
_UNSEEN_HEAT = np.array([60.0 if "winding" in name else 20.0 if name.endswith("oil") else 10.0 for name in NODES])
_UNSEEN_SHARE = 0.5
_DUTY_MEMORY = 600.0  # s over which the usual heat of a node is remembered
LONGEST_DELAY = 60.0
"""s by which a reading may come late and is still used."""
_REST_STEP, _LONGEST_REST = 60.0, 86400.0  # s; after a day the unit is at rest, and longer steps would not be stable
_REST_END, _REST_END_STEP = 60.0, 1.0  # s: towards the end of a rest what is unknown of a node comes to its lagged reading
_REST_AMBIENT_DRIFT, _REST_AMBIENT_TIME = 6.0, 6.0 * 3600.0  # K, s: how far the air may move, and how soon
_NO_VARIANCE = 1e-12  # K^2


class TemperatureFusion:
    """The filter with its bookkeeping.

    Args:
        rig: the rig, its tolerances are the filter's priors. interval: s. ambient: K at the start, None takes the sheet's.

    Attributes:
        state: all that it knows. trace: where its steps are written for a smoother, None: nowhere.
        left_out: of `SENSORS`, whether their readings are not used, until `use_again` or `reset`, bool (m,).
    """

    def __init__(self, rig: Rig, interval: float = INTERVAL, ambient: float | None = None) -> None:
        self.trace: Trace | None = None
        self._row = 0  # intervals since the trace was begun
        self.rig = rig
        self.interval = interval
        self.parameters = rig.parameters
        self._per_epoch = max(1, round(EPOCH / interval))
        self._node = np.array([NODE_INDEX[sensor] for sensor in SENSORS])
        self._lag, self._noise = sensor_lags(rig), temperature_noise(rig)
        self._first_air = ZERO_CELSIUS + rig["ambient"] if ambient is None else ambient
        self._first_air_known = ambient is not None
        self._longest_delay = round(LONGEST_DELAY / interval)
        self._transition = np.empty((N + _M, N + _M + N_UNCERTAIN))
        self.left_out = np.zeros(_M, bool)
        self._without_air = False
        self.reset()

    @property
    def contradicted(self) -> list[str]:
        """Sensors that are not used at present, as all others contradict them, a line of each; see `outvoted`."""
        return told_outvoted(self._newest, self.state.ambient if self.state.ambient_known else np.nan)

    def begin_trace(self) -> Trace:
        """Write all steps from here on into a new trace, whose rows count the intervals from here on."""
        self.trace, self._row = Trace(round(SMOOTHED_EVERY / (self._per_epoch * self.interval))), 0
        return self.trace

    def reset(self) -> None:
        """Forget everything: temperatures near ambient, wide uncertainty."""
        self.left_out[:] = self._without_air = False
        self._air = AmbientTracker(self._first_air, self.interval)
        self._air.hold(self._first_air, self._first_air_known)
        self._begin(self._first_air, self._first_air_known)

    def leave_out(self, sensors: Sequence[str], temperature: np.ndarray, air: float = np.nan) -> None:
        """Use these sensors, if any, no more and forget what was learned, but for the air and the usual duty.

        The uncertainty is that of a start again, about temperatures that the models say, behind which sensors may lag; the others soon
        narrow it.

        Args:
            temperature: K, (N,), of a run that does not rest on these sensors. air: K, that is held where ``ambient`` is one of them.
        """
        self.left_out |= np.isin(SENSORS, sensors)
        if "ambient" in sensors:
            self._without_air = True
            self._air.hold(air, True)
        self._begin_again(self._air.value, self._air.known)
        self.state.dynamic[:N] = temperature
        self.state.dynamic[N:] = all_sensed(temperature, self.rig["tank.top_share"])
        self._lag_behind()

    def use_again(self, sensors: Sequence[str]) -> None:
        """Use these sensors, which were left out: their next readings are believed as first ones are."""
        self.left_out &= ~np.isin(SENSORS, sensors)
        self._without_air &= "ambient" not in sensors

    def _begin_from_readings(self, air: float, air_known: bool) -> None:
        """Begin in the midst of a call, in air of K: the next reading of a sensor that agrees with its last ones is believed.

        The unit may be running, so that a sensor may lag behind what it reads, by what heats it unseen in the sensor's time constant.
        """
        last, newest, silent = self._last, self._newest, self._silent
        told = self.state.ambient, self.state.ambient_known  # at the end of the call
        self._begin_again(air, air_known)
        self._last, self._newest, self._silent = last, newest, silent
        self.state.ambient, self.state.ambient_known = told
        self._lag_behind()
        self._forget_traced()

    def _forget_traced(self) -> None:
        """Let no reading from here on tell a smoother of before."""
        if self.trace is not None:
            self.trace.forget(*range(self.state.covariance.shape[0]))
            self.trace.moved(0.0, np.eye(*self._transition.shape))

    def _lag_behind(self) -> None:
        """Let each sensor lag behind what it reads, by as much as is not known of it."""
        capacity, reading = np.empty(N), np.arange(N, N + _M)
        capacities(self.parameters, 0.0, capacity)
        self.state.covariance[reading, reading] += (self._lag * _UNSEEN_HEAT[self._node] / capacity[self._node]) ** 2

    def _begin_again(self, air: float, air_known: bool) -> None:
        """Begin with what is known of the usual duty."""
        usual = self.state.usual_heat
        self._begin(air, air_known)
        self.state.usual_heat = usual

    def _begin(self, air: float, air_known: bool) -> None:
        """Temperatures as of the air, K, with wide uncertainty."""
        self._forget_past()
        size = N + 2 * _M + N_UNCERTAIN
        covariance = np.zeros((size, size))
        covariance[:N, :N] = start_covariance()
        dynamic_rows = np.concatenate([np.arange(N), self._node])
        covariance[: N + _M, : N + _M] = covariance[np.ix_(dynamic_rows, dynamic_rows)]
        offset, spread = temperature_zero_errors(self.rig)
        covariance[N + _M: N + 2 * _M, N + _M: N + 2 * _M] = np.diag(spread**2)
        prior = uncertain_parameters(self.rig).prior
        covariance[N + 2 * _M:, N + 2 * _M:] = np.diag(prior**2)
        if not air_known:
            covariance[N + 2 * _M + AMBIENT_AT, N + 2 * _M + AMBIENT_AT] = UNKNOWN_AMBIENT**2
        self.state = FusionState(
            np.full(N + _M, air), offset.copy(), np.zeros(N_UNCERTAIN), covariance, air, _UNSEEN_HEAT.copy(), air_known,
        )
        self.state.deviation[AMBIENT_AT] = self.rig["surroundings.enclosure_rise"]
        self._departures = Departures()
        self._last = np.full((_M, 2), np.nan)  # K, last two readings of each sensor
        self._newest = np.full(_M, np.nan)  # K, last reading of each sensor within `HEARD` and since the last rest
        self._silent = np.zeros(_M)  # s since then
        self._late = np.zeros(_M, bool)  # sensors that spoke after a silence of `HEARD` and are not believed yet
        self._colder = np.zeros(_M)  # K, of the motor's sensors when they were last read, see `colder_than_all`
        self._clear_epoch()

    def _forget_past(self) -> None:
        """Lagged readings of the last intervals, K, each less what had been learned of them by then, `_learned`, (m,)."""
        self._past: deque[tuple[int, np.ndarray]] = deque()
        self._past_length, self._learned = 0, np.zeros(_M)

    def restore(self, state: FusionState, age: float) -> None:
        """Go on from an earlier state after ``age`` seconds without the twin; see `rest`."""
        self.state = state
        self._departures = Departures()
        self._last[:] = np.nan
        self._air.hold(state.ambient, state.ambient_known)
        self.rest(age)

    def _clear_epoch(self) -> None:
        self._count = 0
        self._heat = np.zeros(N)
        self._unknown = np.zeros(N)
        self._seen_heat, self._seen = np.zeros(N), [0] * len(_GROUPS)  # W summed over intervals that told it; their number by group
        self._flow = np.zeros(N_FLOWS)
        self._square = 0.0
        self._position = 0.0
        self._pending: list[tuple[np.ndarray, ...]] = []  # index, sensor, measured, expected, noise

    def advance(self, inputs: FusionInputs, readings: Sequence[Reading] | Readings = ()) -> FusionResult:
        """Move over n intervals and take in the readings made in them, at the end of each epoch.

        Readings of sensors that the network does not know are passed over, those of ``ambient``
        set the air as `FusionInputs.ambient` does. A reading of an earlier interval (index below 0) is
        compared with what was expected then, corrected by what was learned since, and its age adds to its noise.
        How the intervals are dealt out to calls does not matter.
        """
        n = len(inputs)
        state = self.state
        assumed, known = state.ambient, state.ambient_known
        ambient, told = self._ambient(inputs, () if isinstance(readings, Readings) else readings)
        given = readings if isinstance(readings, Readings) else Readings.of(readings)
        given = given.off_the_air(np.append(ambient, assumed), self.rig)  # a late one before the call meets the air before it
        temperature, deviation = np.empty((n, N)), np.empty((n, N))
        expected = np.empty((n, _M))
        innovations: list[Innovation] = []
        begun_anew: list[LeftTogether] = []
        heat = np.ascontiguousarray(inputs.heat)
        self._take_late(given)
        start = 0
        while start < n:
            if start == told:
                self._trust_ambient(ambient[told] - assumed)
            stop = min(n, start + self._per_epoch - self._count, told if start < told else n)
            rows = slice(start, stop)
            advance_mean(
                self.parameters, state.dynamic, state.deviation, self._node, self._lag, heat[rows],
                inputs.mean_square_current[rows], inputs.flow[rows], inputs.rod_position[rows], ambient[rows],
                self.interval, temperature[rows], expected[rows],
            )
            now = given.between(start, stop)
            if now.index.size:
                self._pending.append((now.index + start, now.sensor, now.temperature,
                                      expected[now.index + start, now.sensor] + state.offset[now.sensor],
                                      self._noise[now.sensor]))
            length = stop - start
            self._heat += heat[rows].sum(axis=0)
            self._take_unseen(heat[rows], inputs.motor_known[rows], inputs.hydraulics_known[rows])
            self._flow += inputs.flow[rows].sum(axis=0)
            self._square += inputs.mean_square_current[rows].sum()
            self._position += inputs.rod_position[rows].sum()
            self._count += length
            deviation[rows] = self._deviation()
            self._past.append((stop - start, expected[rows] - self._learned))
            self._past_length += stop - start
            if self._past_length - self._past[0][0] >= self._longest_delay:
                self._past_length -= self._past.popleft()[0]
            if self._count >= self._per_epoch:
                applied, left = self._close_epoch(ambient[stop - 1], known or stop > told, stop)
                state = self.state
                innovations += applied
                begun_anew += left
                temperature[stop - 1] = state.dynamic[:N]
                expected[stop - 1] = state.dynamic[N:]
                deviation[stop - 1] = self._deviation()
                if self.trace is not None:
                    self.trace.estimated(self._row + stop - 1, state.dynamic, state.deviation[UNKNOWN_HEAT_AT:], state.covariance)
            start = stop
        self._row += n
        # counted from the start of the next call, what waits for the end of its epoch lies before it
        self._pending = [(index - n, *rest) for index, *rest in self._pending]
        spread = np.sqrt(np.maximum(np.diagonal(state.covariance)[N: N + _M], 0.0))
        return FusionResult(temperature, deviation, ambient, expected, spread, innovations, begun_anew)

    def unsure_of_copper(self, share: float) -> None:
        """Copper losses may be off by this share of themselves, beside the sheet's tolerance, from here on.

        What was learned before, by another current, is forgotten, about the temperatures as they are.
        """
        self.leave_out((), self.state.dynamic[:N].copy())
        self._forget_traced()
        at = N + 2 * _M + COPPER_AT
        self.state.covariance[at, at] += share**2

    def _take_late(self, given: Readings) -> None:
        """Readings of intervals before this call: what was expected then, noise that grows with their age.

        The error of a lagged reading changes at the rate (error of node - error of reading) / lag.
        """
        late = np.flatnonzero((given.index < 0) & (given.index >= -self._past_length))
        if not late.size:
            return
        past = np.concatenate([rows for _, rows in self._past]) + self._learned
        index, sensor, covariance = given.index[late], given.sensor[late], self.state.covariance
        node, reading = self._node[sensor], N + sensor
        apart = np.sqrt(np.maximum(covariance[node, node] + covariance[reading, reading] - 2.0 * covariance[node, reading], 0.0))
        self._pending.append((index, sensor, given.temperature[late], past[index, sensor] + self.state.offset[sensor],
                              np.hypot(self._noise[sensor], apart / self._lag[sensor] * -index * self.interval)))

    def _deviation(self) -> np.ndarray:
        """Standard deviation of the node temperatures now, K, (N,)."""
        return np.sqrt(np.maximum(np.diagonal(self.state.covariance)[:N], 0.0))

    def _close_epoch(self, ambient: float, air_known: bool, stop: int) -> tuple[list[Innovation], list[LeftTogether]]:
        """Move the covariance up to interval ``stop`` of the call and apply what waits, to a new state where sensors left together."""
        state, count = self.state, self._count
        predict_covariance(
            self.parameters, state.dynamic, state.deviation, state.covariance, self._node, self._lag,
            self._heat / count, self._unknown / count, self._square / count, self._flow / count,
            self._position / count, ambient, count * self.interval, self._transition,
        )
        if self.trace is not None:
            self.trace.moved(count * self.interval, self._transition)
        self._learn_usual_heat()
        pending = self._pending
        self._clear_epoch()
        self._silent += count * self.interval
        self._newest[self._silent > HEARD] = np.nan
        self._departures.pass_by(count * self.interval)
        if not pending:
            return [], []
        index, sensor, measured, predicted, noise = (np.concatenate(column) for column in zip(*pending, strict=True))
        self._late[sensor] |= self._silent[sensor] > HEARD
        self._newest[sensor], self._silent[sensor] = measured, 0.0
        self._newest[self.left_out] = np.nan
        air = ambient if air_known else np.nan
        self._doubt_zeros(sensor, air)
        doubted = outvoted(self._newest, air) | self.left_out
        applied = self._apply(index, sensor, measured, measured - predicted, noise, doubted[sensor])
        left = self._departures.together(stop - 1, state.refused, self._last, ~doubted, self._silent)
        if left is None:
            return applied, []
        self._begin_from_readings(ambient, air_known)
        here = index >= stop - count  # what came late is of the state before
        index, sensor, measured, noise = index[here], sensor[here], measured[here], noise[here]
        predicted = self.state.dynamic[N + sensor] + self.state.offset[sensor]
        return self._apply(index, sensor, measured, measured - predicted, noise, doubted[sensor]), [left]

    def _doubt_zeros(self, sensor: np.ndarray, air: float) -> None:
        """Let the zero error of a motor's sensor be as large as it is colder than all that is read, in two of these epochs in a row.

        Args:
            sensor: those that were read, (r,). air: K, NaN where nobody told it.
        """
        now = np.where(np.isin(np.arange(_M), sensor), colder_than_all(self._newest, air), self._colder)
        lasting = np.where(now > COLDER, np.minimum(now, self._colder), 0.0)
        self._colder = now
        for k in np.flatnonzero(lasting > COLDER):
            at = N + _M + k
            self.state.covariance[at, at] = max(self.state.covariance[at, at], lasting[k] ** 2)

    def _apply(self, index: np.ndarray, sensor: np.ndarray, measured: np.ndarray, innovation: np.ndarray, noise: np.ndarray,
               doubted: np.ndarray) -> list[Innovation]:
        """Apply readings, K, (r,) each, the noise with which they count and whether all others contradict them."""
        state = self.state
        accepted, spread = np.zeros(index.size, dtype=np.bool_), np.zeros(index.size)
        gains = np.empty((index.size, state.covariance.shape[0]))
        before = state.dynamic[N:].copy()
        update(state.dynamic, state.offset, state.deviation, state.covariance, sensor, measured, innovation,
               noise, doubted, self._late, state.refused, self._last, accepted, spread, gains)
        self._learned += state.dynamic[N:] - before
        if self.trace is not None:
            self.trace.read(gains[accepted], sensor[accepted], innovation[accepted], spread[accepted])
        self._departures.take(sensor, measured, measured - innovation, spread, accepted)
        columns = (index, sensor, measured, measured - innovation, spread, accepted)
        return [Innovation(i, SENSORS[k], m, e, d, a) for i, k, m, e, d, a in zip(*(c.tolist() for c in columns), strict=True)]

    def _ambient(self, inputs: FusionInputs, readings: Sequence[Reading]) -> tuple[np.ndarray, int]:
        """Smoothed air temperature of each interval, K, and the interval whose reading ends the doubt about it, n where none."""
        own = air_of(readings, len(inputs))
        read = np.full(len(inputs), np.nan) if self._without_air else np.where(np.isfinite(own), own, inputs.ambient)
        known = self._air.known
        ambient = self._air.advance(read)
        told = int(np.isfinite(read).argmax()) if self._air.known and not known else read.size
        self.state.ambient, self.state.ambient_known = self._air.value, self._air.known
        return ambient, told

    def _trust_ambient(self, warmer: float) -> None:
        """End the doubt about the air, which is warmer than assumed, K; a unit that no sensor read moves with it."""
        if np.all(self.state.refused == NEVER_READ) and np.all(np.isnan(self._last)):
            self.state.dynamic += warmer
            self._learned += warmer
            self._pending = [(index, sensor, measured, expected + warmer, noise)
                             for index, sensor, measured, expected, noise in self._pending]
        covariance, at = self.state.covariance, N + 2 * _M + AMBIENT_AT
        if self.trace is not None:
            self.trace.forget(at)
        covariance[at, :] = 0.0
        covariance[:, at] = 0.0
        covariance[at, at] = uncertain_parameters(self.rig).prior[AMBIENT_AT] ** 2

    def _take_unseen(self, heat: np.ndarray, motor_known: np.ndarray, hydraulics_known: np.ndarray) -> None:
        """Gather how unsure the heat of intervals is that no telemetry tells, and what is usual where it does.

        Args:
            heat: W, (n, N). motor_known, hydraulics_known: of each interval, (n,).
        """
        usual = self.state.usual_heat
        for group, known in enumerate((motor_known, hydraulics_known)):
            nodes, seen = _GROUPS[group], np.count_nonzero(known)
            size, unseen = np.abs(heat[:, nodes]), known.size - seen
            if unseen:
                self._unknown[nodes] += unseen * usual[nodes] + _UNSEEN_SHARE * size[~known].sum(axis=0)
                size = size[known]
            self._seen_heat[nodes] += size.sum(axis=0)
            self._seen[group] += seen

    def _learn_usual_heat(self) -> None:
        """Move what heat is usual towards that of the epoch's intervals in which telemetry told it."""
        usual = self.state.usual_heat
        for nodes, seen in zip(_GROUPS, self._seen, strict=True):
            if seen:
                weight = min(1.0, seen * self.interval / _DUTY_MEMORY)
                usual[nodes] += weight * (self._seen_heat[nodes] / seen - usual[nodes])

    def rest(self, age: float) -> None:
        """Let ``age`` seconds pass in which the machine may have stood or run unseen.

        Temperatures relax to ambient; the uncertainty grows by the heat that usual duty would
        have brought and by what the air may have done. Nothing is known better for it: errors that relax faster
        than that heat brings new ones are kept as large as they were, with their correlations.
        """
        state = self.state
        before = np.diagonal(state.covariance)[: N + _M].copy()
        at = N + 2 * _M + AMBIENT_AT
        left = min(age, _LONGEST_REST)
        for span in _rests(left):
            expected = np.empty((1, _M))
            temperature = np.empty((1, N))
            zero = np.zeros((1, N))
            advance_mean(self.parameters, state.dynamic, state.deviation, self._node, self._lag, zero, np.zeros(1),
                         np.zeros((1, N_FLOWS)), np.zeros(1), np.full(1, state.ambient), span, temperature, expected)
            predict_covariance(
                self.parameters, state.dynamic, state.deviation, state.covariance, self._node, self._lag, zero[0],
                np.maximum(state.usual_heat, 5.0), 0.0, np.zeros(N_FLOWS), 0.0, state.ambient, span, self._transition,
            )
            if self.trace is not None:
                self.trace.moved(span, self._transition)
            left -= span
            drifted = np.exp(-2.0 * left / _REST_AMBIENT_TIME) * -np.expm1(-2.0 * span / _REST_AMBIENT_TIME)
            state.covariance[at, at] += _REST_AMBIENT_DRIFT**2 * drifted
        kept = np.ones(state.covariance.shape[0])
        kept[: N + _M] = np.sqrt(np.maximum(before / np.maximum(np.diagonal(state.covariance)[: N + _M], _NO_VARIANCE), 1.0))
        state.covariance *= np.outer(kept, kept)
        self._newest[:] = np.nan
        self._forget_past()
        self._clear_epoch()


def _rests(age: float) -> np.ndarray:
    """Steps of a rest of ``age`` s, s, the last ones short; none where it does not last."""
    if age <= 0.0:
        return np.empty(0)
    end = min(age, _REST_END)
    before, steps = age - end, int(np.ceil((age - end) / _REST_STEP))
    short = int(np.ceil(end / _REST_END_STEP))
    return np.concatenate([np.full(steps, before / max(steps, 1)), np.full(short, end / short)])
