"""Whose clock is believed where streams part, by what each node hears: the votes of `TickAligner`."""

import math

import numpy as np
import pytest
from ddh_twin_py.telemetry.alignment.tick_aligner import TickAligner

EPOCH = 1_772_000_000_000_000_000
MS = 1_000_000
DRIVE, HYDRAULICS, STATE, MOTOR = "drive/telemetry", "hydraulics/telemetry", "hydraulics/state", "motor/thermal_state"
SENSORS = tuple(f"temperature/{name}" for name in ("ambient", "tank_oil", "motor_housing", "line_a", "line_b", "pump_1_case"))
BREAKS = 29.7  # s at which clocks jump
SECONDS = 75


class Graph:
    """The three aligners of a running twin: two models on telemetry, the fusion on sensors and models.

    `jump` maps a stream to the s by which its stamps are off from `BREAKS` on, until s `back`; `apart` how many s later it jumps than that.
    Messages come `burst` s at once, one stream after the other, and nodes work off what there is before the next; `timed`: by a computer's
    clock, which is right. `ticks` are each node's,
    `aligners` by node.
    """

    def __init__(self, sensors=SENSORS, period=1.0, jump=(), back=math.inf, burst=0.0, apart=(), fast=0.05, timed=False):
        telemetry = (DRIVE, HYDRAULICS, *sensors)
        self.jump, self.back, self.apart = dict(jump), back, dict(apart)
        models = {"hydraulic_model": STATE, "machine_thermal": MOTOR}
        self.aligners = {node: TickAligner(dict.fromkeys(telemetry, 1), timeout=2.0, awaited=[DRIVE, HYDRAULICS]) for node in models}
        self.aligners["temperature_fusion"] = fusion = TickAligner(
            dict.fromkeys((*sensors, STATE, MOTOR), 1), timeout=5.0, awaited=[STATE, MOTOR], followers=[STATE, MOTOR])  # fmt: skip
        self.ticks = {node: [] for node in self.aligners}
        arrivals = sorted(
            ((math.ceil(t / burst) * burst if burst else t), k if burst else 0, t, name)
            for k, name in enumerate(telemetry) for t in np.arange(0.01 * (k + 1), SECONDS, period if name in sensors else fast).tolist()
        )  # fmt: skip
        for looked, (at, _, t, name) in enumerate(arrivals):
            stamp, came = self.stamp(name, t), EPOCH + round(at * 1e9) if timed else None
            for node in models:
                self.aligners[node].push(name, stamp, [t], came)
            if name in sensors:
                fusion.push(name, stamp, [t], came)
            if looked + 1 == len(arrivals) or arrivals[looked + 1][0] > at:
                for node, model in models.items():
                    for tick in self._take(node, burst > 2.0):
                        fusion.push(model, tick.end_ns, [float(bool(len(tick.samples[DRIVE])))], came)
                self._take("temperature_fusion", burst > 2.0)

    def stamp(self, name, t):
        off = self.jump.get(name, 0.0) if BREAKS + self.apart.get(name, 0.0) < t <= self.back else 0.0
        return EPOCH + round((t + off) * 1e9)

    def _take(self, node, flush):
        ticks = list(self.aligners[node].flush() if flush else self.aligners[node].ready())
        self.ticks[node] += ticks
        return ticks

    @property
    def restarts(self):
        """How often each node's ticks began anew."""
        return {node: sum(tick.restart for tick in ticks) for node, ticks in self.ticks.items()}

    def heard(self, node, stream, after):
        """Share of the ticks from a time on, s by the clock that never jumped, in which a stream tells."""
        ticks = [tick for tick in self.ticks[node] if tick.end_ns > EPOCH + after * 1e9]
        return sum(len(tick.samples[stream]) > 0 for tick in ticks) / len(ticks)


NOBODY = dict.fromkeys(("hydraulic_model", "machine_thermal", "temperature_fusion"), 0)
ONCE = dict.fromkeys(NOBODY, 1)
STEPS = (-3600.0, -60.0, 60.0, 700.0)


@pytest.mark.parametrize("burst", [0.0, 3.0])
@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("alone", [DRIVE, HYDRAULICS, SENSORS[0]])
@pytest.mark.parametrize("sensors", [1, 3])
def test_a_clock_that_jumps_alone_is_left_out_by_all_and_named(sensors, alone, step, burst):
    graph = Graph(SENSORS[:sensors], jump={alone: step}, back=BREAKS + 20.0, burst=burst)
    assert graph.restarts == NOBODY
    for node, aligner in graph.aligners.items():
        if (alone, "other_clock") in aligner.counts:
            assert aligner.strayed[alone, "other_clock"] == pytest.approx(step * 1e9, abs=4e9)
        assert not any(cause == "clock_jump" for _, cause in aligner.counts)
        assert {name for (name, cause), count in aligner.counts.items() if count and cause == "other_clock"} <= {alone}
        assert graph.ticks[node][-1].end_ns > EPOCH + (SECONDS - 6.0) * 1e9
    assert graph.aligners["hydraulic_model"].counts[alone, "other_clock"]
    if not burst:  # once its clock is back, all of it is heard
        assert alone in SENSORS or graph.heard("hydraulic_model", alone, BREAKS + 25.0) == 1.0
        assert graph.heard("temperature_fusion", MOTOR, BREAKS + 25.0) == 1.0


@pytest.mark.parametrize("step", [-8.0, -3.0, 3.0, 5.0, 8.0])
@pytest.mark.parametrize("alone", [DRIVE, HYDRAULICS])
@pytest.mark.parametrize("sensors", [0, 1, 6])
def test_a_clock_that_steps_some_seconds_alone_is_left_out_by_all_and_named(sensors, alone, step):
    graph = Graph(SENSORS[:sensors], jump={alone: step}, back=BREAKS + 20.0)
    assert graph.restarts == NOBODY
    for node in ("hydraulic_model", "machine_thermal"):
        counts = graph.aligners[node].counts
        assert {name for name, count in counts.items() if count} <= {(alone, "other_clock"), (alone, "late")}
        assert graph.aligners[node].strayed[alone, "other_clock"] == pytest.approx(step * 1e9, abs=1e9)
        assert graph.heard(node, alone, BREAKS + 25.0) == 1.0
    assert not any(cause == "other_clock" for _, cause in graph.aligners["temperature_fusion"].counts)


@pytest.mark.parametrize("step", [3.0, 8.0])
@pytest.mark.parametrize("sensors", [1, 6])
def test_a_sensor_that_steps_some_seconds_alone_costs_no_other_stream_anything(sensors, step):
    graph = Graph(SENSORS[:sensors], jump={SENSORS[0]: step}, back=BREAKS + 20.0)
    assert graph.restarts == NOBODY
    for aligner in graph.aligners.values():
        assert aligner.counts[SENSORS[0], "other_clock"] and {name for name, _ in aligner.counts} == {SENSORS[0]}


@pytest.mark.parametrize("step", [3.0, 8.0])
@pytest.mark.parametrize("sensors", [0, 1, 6])
def test_where_all_leave_out_seconds_nothing_is_lost(sensors, step):
    names = SENSORS[:sensors]
    graph = Graph(names, jump=dict.fromkeys((DRIVE, HYDRAULICS, *names), step))
    assert graph.restarts == NOBODY and not any(aligner.counts for aligner in graph.aligners.values())
    after = BREAKS + step + 0.1
    assert graph.heard("hydraulic_model", DRIVE, after) == graph.heard("temperature_fusion", MOTOR, after) == 1.0


@pytest.mark.parametrize("period", [0.1, 4.0, 10.0])
@pytest.mark.parametrize("step", [-60.0, 700.0])
def test_sensors_of_any_rate_are_heard_against_the_drive_alone(step, period):
    assert Graph(SENSORS[:3], period, jump={DRIVE: step}, back=BREAKS + 20.0).restarts == NOBODY


@pytest.mark.parametrize("burst", [0.0, 3.0, 8.0])
@pytest.mark.parametrize(("sensors", "period"), [(0, 1.0), (1, 0.1), (1, 10.0), (6, 1.0)])
@pytest.mark.parametrize("step", [-3600.0, -60.0, 700.0])
def test_where_all_jump_together_all_nodes_begin_anew_once(step, sensors, period, burst):
    names = SENSORS[:sensors]
    graph = Graph(names, period, jump=dict.fromkeys((DRIVE, HYDRAULICS, *names), step), burst=burst)
    assert graph.restarts == ONCE
    for node, ticks in graph.ticks.items():
        assert ticks[-1].end_ns > EPOCH + (SECONDS + step - 13.0) * 1e9, node


@pytest.mark.parametrize("step", [-3600.0, -60.0])
def test_streams_that_jump_within_seconds_begin_anew_once(step):
    """As of a machine that is started again, one part of it after the other."""
    apart = {HYDRAULICS: 2.0, SENSORS[0]: 1.0, SENSORS[1]: 2.5}
    graph = Graph(SENSORS[:2], jump=dict.fromkeys((DRIVE, HYDRAULICS, *SENSORS[:2]), step), apart=apart)
    assert graph.restarts == ONCE


@pytest.mark.parametrize("alone", [DRIVE, HYDRAULICS])
@pytest.mark.parametrize("step", STEPS)
def test_of_two_streams_the_one_that_goes_on_is_believed(alone, step):
    graph = Graph((), jump={alone: step}, back=BREAKS + 20.0)
    assert graph.restarts == NOBODY
    assert graph.heard("hydraulic_model", alone, BREAKS + 25.0) == 1.0


def test_the_majority_is_believed():
    """Drive and hydraulics of one computer jump: against one sensor they are believed, against three not."""
    together = {DRIVE: -3600.0, HYDRAULICS: -3600.0}
    assert Graph(SENSORS[:3], jump=together).restarts == NOBODY
    few = Graph(SENSORS[:1], jump=together)
    assert few.restarts["hydraulic_model"] == few.restarts["machine_thermal"] == 1
    assert few.aligners["hydraulic_model"].counts[SENSORS[0], "other_clock"], "the sensor of the old clock does not pull them forth"


@pytest.mark.parametrize("burst", [0.0, 3.0])
@pytest.mark.parametrize("step", [*STEPS, 15.0])
def test_sensors_of_one_logger_do_not_outvote_a_machine_that_goes_by_the_computers_clock(step, burst):
    graph = Graph(jump=dict.fromkeys(SENSORS, step), burst=burst, timed=True)
    assert graph.restarts == NOBODY
    for node, aligner in graph.aligners.items():
        assert {(name, cause) for (name, cause), count in aligner.counts.items() if count} == {(name, "other_clock") for name in SENSORS}
        assert graph.heard(node, STATE if node == "temperature_fusion" else DRIVE, BREAKS) > 0.98


@pytest.mark.parametrize("step", STEPS)
def test_nor_do_they_where_they_tell_another_clock_from_the_begin(step):
    graph = Graph(jump=dict.fromkeys(SENSORS, step), apart=dict.fromkeys(SENSORS, -BREAKS), timed=True)
    assert max(graph.restarts.values()) <= 1
    ticks = {name: sum(len(tick.samples[name]) for tick in graph.ticks[node])
             for node, name in (("hydraulic_model", DRIVE), ("machine_thermal", HYDRAULICS), ("temperature_fusion", MOTOR))}
    assert min(ticks.values()) > 0.9 * SECONDS / 0.05


@pytest.mark.parametrize("ahead", [15.0, 60.0, 700.0, 7200.0])
@pytest.mark.parametrize("sensors", [1, 3, 6])
def test_a_drive_that_speaks_first_by_a_clock_ahead_is_left_out_once_more_tell_another(sensors, ahead):
    graph = Graph(SENSORS[:sensors], jump={DRIVE: ahead}, apart={DRIVE: -BREAKS})
    for node in ("hydraulic_model", "machine_thermal"):
        counts = graph.aligners[node].counts
        assert counts[DRIVE, "other_clock"] > 0.9 * SECONDS / 0.05
        assert sum(count for (_, cause), count in counts.items() if cause == "clock_jump") == 1
        told = {name: sum(len(tick.samples[name]) for tick in graph.ticks[node]) for name in (DRIVE, HYDRAULICS)}
        assert told[DRIVE] < 0.1 * SECONDS / 0.05 and told[HYDRAULICS] > 0.9 * SECONDS / 0.05
    fusion = graph.ticks["temperature_fusion"]
    assert sum(len(tick.samples[SENSORS[0]]) for tick in fusion) > 0.9 * SECONDS
    assert sum(len(tick.samples[STATE]) > 0 for tick in fusion) > 0.8 * SECONDS / 0.05


@pytest.mark.parametrize("ahead", [15.0, 60.0])
def test_of_two_streams_from_the_begin_apart_the_one_that_spoke_first_is_believed(ahead):
    graph = Graph((), jump={DRIVE: ahead}, apart={DRIVE: -BREAKS})
    assert not any(cause == "clock_jump" for aligner in graph.aligners.values() for _, cause in aligner.counts)
    assert sum(len(tick.samples[DRIVE]) for tick in graph.ticks["hydraulic_model"]) > 0.9 * SECONDS / 0.05


@pytest.mark.parametrize("sensors", [0, 6])
@pytest.mark.parametrize("period", [1.0, 4.0, 10.0])
@pytest.mark.parametrize("step", [-0.8, -3.0, -4.5, -8.0])
def test_a_step_back_that_ends_before_all_have_spoken_is_found(step, period, sensors):
    names = SENSORS[:sensors]
    graph = Graph(names, period, jump=dict.fromkeys((DRIVE, HYDRAULICS, *names), step))
    for node in ("hydraulic_model", "machine_thermal"):
        (restart,) = [tick for tick in graph.ticks[node] if tick.restart]
        assert restart.gap == pytest.approx(step, abs=0.15)
        assert all(len(tick.samples[DRIVE]) for tick in graph.ticks[node][1:])
