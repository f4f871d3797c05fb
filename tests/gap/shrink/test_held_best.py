"""Held-out data with what is open of rig and begin taken at its best."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.binning import by_cycle, cycle_of
from ddh_twin_py.estimation.fitting.experiment import Signal
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.shrink.held_best import AtBest, HeldBest
from ddh_twin_py.gap.shrink.held_runs import HeldRuns
from ddh_twin_py.gap.shrink.open_rig import asked_of_rig, told
from ddh_twin_py.gap.shrink.size import counted

NOISE, STEP = 0.02, 0.05


class Warming:
    """y = gain u + 0.5 begin exp(-t / 20 s) + bend t^2; ``gain`` is 1 + 0.1 of its deviation, ``other`` moves nothing."""

    words = "made"

    def __init__(self, gain=0.0, begin=0.0, bend=0.0, is_open=True):
        self._command = np.repeat([-1.0, 0.0, 1.0, 0.0, 1.0, -1.0] * 5, 60)
        self._time, self._open = STEP * np.arange(self._command.size), is_open
        binning = by_cycle(cycle_of(self._command, STEP), self._time, np.ones(self._time.size, dtype=bool))
        true = self._flow(gain, begin) + bend * (self._time / self._time[-1]) ** 2
        read = true + np.random.default_rng(0).normal(0.0, NOISE, true.size)
        self._signals = [{"flow": Signal(self._time, read, NOISE, "m3/s", binning)}]

    def _flow(self, gain, begin):
        return (1.0 + 0.1 * gain) * self._command + 0.5 * begin * np.exp(-self._time / 20.0)

    def signals(self):
        return self._signals

    def mask(self):
        return counted

    def open_begins(self):
        return [int(self._open)]

    def run(self, theta, acting, begin=None, roughly=False):
        return [{"flow": self._flow(theta[0], 0.0 if begin is None or not len(begin[0]) else begin[0][0])}]


def left(held, open_gain=0.5):
    best = HeldBest(held, {"flow": 1.0}, lambda theta: np.clip(theta, -3.0, 3.0), np.zeros(2), np.diag([open_gain, 0.01]) ** 2)
    return best.beside(np.zeros(2), ()).over["flow"]


def test_what_is_open_explains_what_it_can():
    assert left(Warming(gain=0.8, begin=-0.7)) == pytest.approx(1.0, abs=0.06)


def test_runs_that_go_astray_are_infinitely_off_whatever_is_open():
    class Astray(Warming):
        def run(self, theta, acting, begin=None, roughly=False):
            return [{"flow": np.full(self._time.size, np.nan)}]

    assert left(Astray()) == np.inf


def test_who_waits_is_told_of_every_run():
    told = []
    best = HeldBest(Warming(gain=0.8), {"flow": 1.0}, lambda theta: theta, np.zeros(2), np.diag([0.5, 0.5]) ** 2, told.append)
    built = len(told)
    best.beside(np.zeros(2), ())
    assert built >= 3 and len(told) > built and sorted(told) == list(range(1, len(told) + 1))


def test_what_nothing_open_explains_stays():
    assert left(Warming(bend=0.4)) > 3.0


def test_a_begin_that_is_read_and_a_parameter_that_is_known_explain_nothing():
    assert left(Warming(begin=0.7, is_open=False)) > 3.0
    assert left(Warming(gain=0.8), open_gain=0.05) > 3.0


def test_a_hypothesis_keeps_to_its_bounds():
    assert left(Warming(gain=6.0), open_gain=5.0) == pytest.approx(0.3 * np.sqrt(2.0 / 3.0) / NOISE, rel=0.1)


def beside(held, open_gain):
    best = HeldBest(held, {"flow": 1.0}, lambda theta: np.clip(theta, -3.0, 3.0), np.zeros(2), np.diag([open_gain, 0.01]) ** 2)
    return best.beside(np.zeros(2), ())


def test_a_move_is_held_against_what_these_data_tell_anew():
    """Of two ways to move, gain and begin, each is expected to be found where these data tell more of it than the fitted ones."""
    found = beside(Warming(gain=0.5, begin=1.0), 0.5)
    assert found.expected == pytest.approx(2.0, abs=0.3) and found.moved == pytest.approx(2.0, abs=0.5) and abs(found.displaced) < 0.5
    assert beside(Warming(gain=2.0, begin=1.0), 0.5).displaced > 3.0, "four deviations of the gain"
    assert beside(Warming(is_open=False), 0.05).expected == 0.0, "nothing is open"


class Opening(Warming):
    """The same with a valve that is open where its deviation is above 1, shut below."""

    def _flow(self, gain, begin):
        return self._command * (1.0 + 0.1 * max(0.0, gain - 1.0))


@pytest.mark.parametrize(("closely", "most"), [(False, np.inf), (True, 1.06)])
def test_a_valve_that_is_shut_where_the_rig_was_fitted_counts_once_it_is_looked_at_closely(closely, most):
    held = Opening(gain=2.8, is_open=False)
    best = HeldBest(held, {"flow": 1.0}, lambda theta: np.clip(theta, -3.0, 3.0), np.zeros(1), np.diag([2.0]) ** 2)
    found = best.beside(np.array([1.5]), (), closely).over["flow"]
    assert found <= most and (closely or found > 4.0)


def asked(held, spread=(1.5, 1.5)):
    """Names of what held-out data ask of a rig whose fit stands at its sheet."""
    parameters = [SimpleNamespace(name=name) for name in ("gain", "other")]
    model = SimpleNamespace(size=2, fitted_parameters=lambda theta, spread: parameters)
    fitted = SimpleNamespace(theta=np.zeros(2), acting=())
    best = HeldBest(held, {"flow": 1.0}, lambda theta: np.clip(theta, -2.5, 2.5), np.zeros(2), np.diag(spread) ** 2)
    return asked_of_rig(model, fitted, best.beside(fitted.theta, ()), HeldRuns(held, {"flow": 1.0}))


@pytest.mark.parametrize(("gain", "bend", "names"), [(2.0, 0.0, "gain"), (0.0, 0.0, ""), (0.0, 0.4, "")])
def test_an_open_parameter_is_named_where_it_explains_what_is_off(gain, bend, names):
    assert asked(Warming(gain=gain, bend=bend, is_open=False)) == names


def test_what_the_fitted_recordings_told_is_not_asked_for():
    assert asked(Warming(gain=2.0, is_open=False), spread=(0.05, 1.5)) == ""


def test_the_note_names_it_with_both_gaps():
    assert "3.9 times the floor off, but 1.0 with another tank.volume: that duty shows" in told(3.94, 1.02, "tank.volume", True)
    assert "with another tank.volume: the end of the recording asks" in told(3.94, 1.02, "tank.volume", False)


class Pushed(Warming):
    """The same with an effect that adds its departure to the flow while the command is above 0; ``pushed``: how much was."""

    def __init__(self, pushed, gain=0.0):
        super().__init__(gain, is_open=False)
        self._signals[0]["flow"].measured[:] += pushed * (self._command > 0.0)

    def run(self, theta, acting, begin=None, roughly=False):
        (flow,) = super().run(theta, (), begin)
        return [{"flow": flow["flow"] + sum(x for _, _, x in acting) * (self._command > 0.0)}]


PUSH = Effect("line.push", "line", "hydraulic", "push", "m3/s", lambda record: 0.0, (), 0.1, lowest=0.0, highest=0.5)


@pytest.mark.parametrize(("pushed", "spread", "found"), [
    (0.2, (), 0.3), (0.2, (0.0,), 0.3), (0.2, (0.1,), 0.2), (0.2, (0.001,), 0.3), (0.9, (0.4,), 0.5),
])  # fmt: skip
def test_held_out_data_ask_for_another_size_as_far_as_it_is_open_and_allowed(pushed, spread, found):
    held = Pushed(pushed)
    best = HeldBest(held, {"flow": 1.0}, lambda theta: theta, np.zeros(1), np.diag([0.01]) ** 2)
    kept, other = best.beside(np.zeros(1), [(PUSH, 0, 0.3)]), best.beside(np.zeros(1), [(PUSH, 0, 0.3)], spread=spread)
    assert kept.departures == pytest.approx([0.3]) and other.departures == pytest.approx([found], abs=0.02)
    assert other.cost({}) <= kept.cost({}) and (other.cost({}) < 0.6 * kept.cost({})) == (found != 0.3)


def test_another_size_costs_its_deviations():
    best = HeldBest(Pushed(0.3 + 0.2), {"flow": 1.0}, lambda theta: theta, np.zeros(1), np.diag([0.01]) ** 2)
    at = best.beside(np.zeros(1), [(PUSH, 0, 0.3)], spread=(0.05,))
    square = (at.departures[0] - 0.3) ** 2 / 0.05**2
    assert at.cost({}) == pytest.approx(10.0 * at.over["flow"] ** 2 + square, rel=0.02) and square > 1.0


def test_what_sums_up_small_flaws_costs_what_is_beyond_its_limit_alone():
    near, far = (AtBest({}, np.zeros(0), np.zeros(0), {"flow": [1.0], "strokes": [square]}, 0.5, 1.0) for square in (1.9, 16.0))
    assert near.cost({}) == pytest.approx(10.0 * 2.9 + 0.5)
    none = AtBest({}, np.zeros(0), np.zeros(0), {"flow": [1.0], "strokes": [0.5]}, 0.5, 1.0)
    assert near.cost({"strokes": 3.0}) == none.cost({"strokes": 3.0})
    assert far.cost({"strokes": 3.0}) - none.cost({"strokes": 3.0}) == pytest.approx(10.0 * (16.0 - 9.0))


def test_what_has_no_say_moves_nothing():
    best = HeldBest(Pushed(0.2), {"flow": 1.0}, lambda theta: theta, np.zeros(1), np.diag([0.01]) ** 2)
    heard, deaf, mute = (best.beside(np.zeros(1), [(PUSH, 0, 0.3)], spread=(0.1,), least={"flow": least}) for least in (0.5, 1e6, np.inf))
    assert heard.departures == pytest.approx([0.2], abs=0.02)
    assert deaf.departures == mute.departures == pytest.approx([0.3]) and deaf.moved == mute.moved == 0.0
    assert mute.cost({"flow": np.inf}) == 0.0


class Often(Pushed):
    """The same recorded so many times."""

    def __init__(self, pushed, times):
        super().__init__(pushed)
        self._signals = self._signals * times

    def open_begins(self):
        return [0] * len(self._signals)

    def run(self, theta, acting, begin=None, roughly=False):
        return super().run(theta, acting) * len(self._signals)


@pytest.mark.parametrize("times", [1, 3])
def test_a_signal_s_say_begins_at_as_many_floors_of_however_many_recordings(times):
    best = HeldBest(Often(0.2, times), {"flow": 1.0}, lambda theta: theta, np.zeros(1), np.diag([0.01]) ** 2)
    off = best.beside(np.zeros(1), [(PUSH, 0, 0.3)]).over["flow"]

    def other(least):
        return best.beside(np.zeros(1), [(PUSH, 0, 0.3)], spread=(0.1,), least={"flow": least})

    assert other(1.05 * off).departures == pytest.approx([0.3]) and other(0.95 * off).departures < 0.29
    assert other(1.05 * off).cost({"flow": 1.05 * off}) == pytest.approx(10.0 * times * (1.05 * off) ** 2)
