"""The three nodes of the twin as processes, fed by the player: the whole way, and what may go wrong on it."""

import signal
import time
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
import yaml
from ddh_twin_py.bags.damage import with_clock_jump, with_stuck_sensor, with_value, with_wrong_unit, without_samples
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.estimation.fusion.state_file import save_state
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.alignment.recording_ticks import align
from ddh_twin_py.telemetry.signals import TEMPERATURE_SENSORS, ZERO_CELSIUS
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nodes.processes import LATCHED, NodeProcess, raw_messages, stamp_ns, wait_for
from sensor_msgs.msg import FluidPressure, JointState, Temperature

from ddh_msgs.msg import HydraulicState, MotorThermalState, NodeProgress, ResidualArray, RigInfo, TemperatureEstimateArray

pytestmark = pytest.mark.live
MODELS = ("hydraulic_model", "machine_thermal", "temperature_fusion")
FLUSH_AFTER = 2.0  # s, as delivered; a machine at work elsewhere holds a player up for half a second, and intervals would end too soon


@pytest.fixture(scope="module")
def graph():
    """The twin, running; each test plays something else into it."""
    nodes = {name: NodeProcess(name, flush_after=FLUSH_AFTER) for name in MODELS}
    yield nodes
    for node, number in zip(nodes.values(), (signal.SIGINT, signal.SIGTERM, signal.SIGINT), strict=True):
        with node:
            node.stop(number)


@contextmanager
def models(namespace):
    """The twin in a namespace of its own, by name, for one test."""
    nodes = {name: NodeProcess(name, namespace, flush_after=FLUSH_AFTER) for name in MODELS}
    try:
        yield nodes
    finally:
        for node in nodes.values():
            with node:
                node.stop()


def play(bag, *wait_for_nodes, namespace="/ddh", **parameters):
    parameters = {"rate": 0.0, "wait_for_nodes": list(wait_for_nodes)} | parameters
    with NodeProcess("bag_player", namespace, bag=str(bag), **parameters) as player:
        assert player.ends() == 0, player.text
        assert "Traceback" not in player.text
        return player.text


@pytest.fixture(scope="module")
def recorded(graph, short_bag, tmp_path_factory):
    """The short bag, played as fast as it goes, everything recorded."""
    path = tmp_path_factory.mktemp("recorded") / "bag"
    with NodeProcess("bag_recorder", bag=str(path), topics=["*", "/diagnostics"], exclude=["none"], log_time="stamp") as recorder:
        play(short_bag, *MODELS, "bag_recorder")
        wait_for_quiet()
        recorder.stop(signal.SIGINT)
        assert "messages: " in recorder.text
    return path


def wait_for_quiet():
    """The models work off what they hold some time after the last message, the fusion as long after them."""
    time.sleep(2.0 * FLUSH_AFTER + 1.0)


def diagnostics(messages, name):
    """Newest status of that name."""
    for message in reversed(messages):
        for status in message.status:
            if status.name == name:
                return status
    return None


def value(status, key):
    return next(entry.value for entry in status.values if entry.key == key)


def test_no_message_is_lost(recorded, short_recording):
    last = {message.node: message for message in raw_messages(recorded, NodeProgress, "/ddh/progress")}
    for node in MODELS:
        received = dict(zip(last[f"/ddh/{node}"].topics, last[f"/ddh/{node}"].received, strict=True))
        for relative, stream in short_recording.streams():
            if f"/ddh/{relative}" in received:
                assert received[f"/ddh/{relative}"] == len(stream), (node, relative)
    assert len(raw_messages(recorded, Temperature, "/ddh/temperature/tank_oil")) == len(short_recording.temperatures["tank_oil"])


def test_outputs_come_at_20_hz_without_a_gap(recorded, short_recording):
    ticks = len(align(short_recording))
    for message_type, topic in (
        (HydraulicState, "hydraulics/state"), (HydraulicState, "hydraulics/prediction"), (MotorThermalState, "motor/thermal_state"),
        (TemperatureEstimateArray, "temperature/estimates"), (Temperature, "estimate/end_winding"),
    ):
        stamps = np.array([stamp_ns(m) for m in raw_messages(recorded, message_type, f"/ddh/{topic}")])
        assert set(np.diff(stamps)) == {50_000_000}, topic
        assert stamps.size == ticks and stamps[0] % 50_000_000 == 0, topic


def test_the_live_graph_agrees_with_replay(recorded, short_recording):
    result = replay(short_recording, load_rig())
    ends = np.rint(result.time * 1e9).astype(np.int64) + short_recording.epoch_ns
    messages = raw_messages(recorded, TemperatureEstimateArray, "/ddh/temperature/estimates")
    assert [e.location for e in messages[0].estimates] == list(NODES)
    place = np.searchsorted(ends, [stamp_ns(m) for m in messages])
    fused = np.array([[e.temperature for e in m.estimates] for m in messages]) + 273.15
    predicted = np.array([[e.predicted for e in m.estimates] for m in messages]) + 273.15
    assert np.abs(fused - result.fused[place]).max() < 0.05  # K; the soft sensor gets the fused temperatures a little later
    assert not np.isnan(predicted).any()
    assert np.abs(predicted - result.free_temperature[place]).max() < 1e-6
    states = raw_messages(recorded, HydraulicState, "/ddh/hydraulics/prediction")
    place = np.searchsorted(ends, [stamp_ns(m) for m in states])
    assert np.abs(np.array([m.pressure_piston_side for m in states]) - result.free["pressure_piston_side"][place]).max() < 1.0  # Pa


def test_the_live_graph_agrees_with_replay_where_sensors_come_late_telemetry_pauses_and_the_clock_is_put_back(
        short_recording, listener, tmp_path):
    """Warm sensors speak from 6 s on, at 8 s there is nothing for 50 s, at 14 s the clock is put back by 3 s and the sensors are gone."""
    broken = short_recording
    for sensor in TEMPERATURE_SENSORS:
        name = f"temperature/{sensor}"
        broken = without_samples(broken, name, 0.0, 6.0)
        broken = without_samples(broken, name, 14.0, 30.0)
        if sensor != "ambient":
            broken = with_value(broken, name, "temperature", 40.0 + ZERO_CELSIUS, 0.0, 8.0)
            broken = with_value(broken, name, "temperature", 45.0 + ZERO_CELSIUS, 8.0, 30.0)
    broken = with_clock_jump(broken, 8.0, 50.0)
    parts = [broken.between(0.0, 64.0), with_clock_jump(broken.between(64.0, 80.0), 0.0, -3.0)]
    bags = [write_recording(tmp_path / name, part) for name, part in zip(("before", "after"), parts, strict=True)]
    broken = with_clock_jump(broken, 64.0, -3.0)
    result = replay(broken, load_rig())
    ends = np.rint(result.time * 1e9).astype(np.int64) + broken.epoch_ns
    assert (np.diff(ends) < 0).sum() == 1
    late = ends - broken.epoch_ns > 59_000_000_000
    assert result.free_temperature[late].min() > 44.0 + ZERO_CELSIUS  # put to what is read, and kept where the clock was put back
    namespace = "/broken"
    topics = [f"{namespace}/hydraulics/prediction", f"{namespace}/motor/thermal_state"]
    predictions, motor = (listener.collect(kind, topic) for kind, topic in zip((HydraulicState, MotorThermalState), topics, strict=True))
    with NodeProcess("hydraulic_model", namespace, flush_after=FLUSH_AFTER) as hydraulics, \
            NodeProcess("machine_thermal", namespace, flush_after=FLUSH_AFTER) as thermal:
        for topic in topics:  # or the first outputs may find no listener
            wait_for(lambda topic=topic: listener.publishers(topic) == 1, 60.0, topic)
        for bag in bags:  # one after the other, or the streams of the bag would not step back together
            play(bag, "hydraulic_model", "machine_thermal", namespace=namespace)
        for messages in (predictions, motor):
            wait_for(lambda messages=messages: messages and stamp_ns(messages[-1]) == ends[-1], 60.0, "the last interval")
        for node in (hydraulics, thermal):
            node.stop()
            assert "the clock was put back by 3." in node.text
    assert [stamp_ns(m) for m in predictions] == [stamp_ns(m) for m in motor] == ends.tolist()
    assert np.abs(np.array([m.temperature for m in predictions]) + ZERO_CELSIUS - result.free_temperature).max() < 1e-6
    housing = motor[0].nodes.index("housing")
    assert min(m.temperature[housing] for m, after in zip(motor, late, strict=True) if after) > 44.0


def test_messages_hold_together(recorded):
    state = raw_messages(recorded, HydraulicState, "/ddh/hydraulics/state")[200]
    losses = {loss.component: loss.power for loss in state.losses}
    heat = dict(zip(state.heat_nodes, state.heat, strict=True))
    assert losses["pump_1"] == pytest.approx(heat["pump_1_case"] + heat["pump_1_oil"], rel=1e-9)
    assert state.mode == "soft_sensor" and state.telemetry_known and state.interval == 0.05
    assert all(flow >= 0.0 for flow in state.flow) and "tank>pump_1" in state.flow_paths
    motor = raw_messages(recorded, MotorThermalState, "/ddh/motor/thermal_state")[200]
    assert motor.hot_spot_temperature == max(t for n, t in zip(motor.nodes, motor.temperature, strict=True) if "winding" in n)
    residuals = raw_messages(recorded, ResidualArray, "/ddh/hydraulics/residuals")
    assert {m.source for m in residuals} == {"soft_sensor", "free_run"}
    for row in residuals[400].residuals:
        assert row.unit and row.residual == pytest.approx(row.measured - row.predicted)
    first = next(m for m in residuals if m.source == "free_run")
    assert all(np.isnan(row.residual) and not np.isnan(row.measured) for row in first.residuals), "what moved before is not known"
    estimate = raw_messages(recorded, TemperatureEstimateArray, "/ddh/temperature/estimates")[300].estimates[NODES.index("tank_oil")]
    location = raw_messages(recorded, Temperature, "/ddh/estimate/tank_oil")[300]
    assert location.temperature == estimate.temperature and location.header.frame_id == "tank_oil"
    assert location.variance == pytest.approx(estimate.standard_deviation**2)
    assert abs(estimate.measured - estimate.temperature) < 1.0 and estimate.measured_age < 2.0


def test_motion_pressures_and_temperatures_come_as_standard_messages_too(recorded):
    for mode, topic in (("soft_sensor", "state"), ("free_run", "prediction")):
        state = {stamp_ns(m): m for m in raw_messages(recorded, HydraulicState, f"/ddh/hydraulics/{topic}")}
        motion = raw_messages(recorded, JointState, f"/ddh/{mode}/joint_states")
        assert {stamp_ns(m) for m in motion} == state.keys()
        one, same = motion[200], state[stamp_ns(motion[200])]
        assert one.name == ["motor", "rod"] and np.isnan(one.position[0])
        assert (one.position[1], *one.velocity) == (same.rod_position, same.speed, same.rod_velocity)
        assert one.effort[0] == same.torque and one.effort[1] == same.cylinder_force
        for side in ("piston_side", "rod_side"):
            pressure = raw_messages(recorded, FluidPressure, f"/ddh/{mode}/pressure_{side}")[200]
            gauge = getattr(state[stamp_ns(pressure)], f"pressure_{side}")
            assert pressure.fluid_pressure == pytest.approx(gauge + 101325.0) and pressure.header.frame_id == side
    state = {stamp_ns(m): m for m in raw_messages(recorded, HydraulicState, "/ddh/hydraulics/prediction")}
    for location in ("tank_oil", "end_winding"):
        for message in raw_messages(recorded, Temperature, f"/ddh/free_run/temperature/{location}")[-3:]:
            said = dict(zip(state[stamp_ns(message)].temperature_nodes, state[stamp_ns(message)].temperature, strict=True))
            assert message.temperature == said[location]


def test_all_nodes_report_their_health(recorded):
    messages = raw_messages(recorded, DiagnosticArray, "/diagnostics")
    names = {status.name for message in messages for status in message.status}
    assert {f"ddh/{node}: {concern}" for node in MODELS for concern in ("clock", "temperature/tank_oil")} <= names
    assert "ddh/bag_recorder: recording" in names
    keys = {entry.key for entry in diagnostics(messages, "ddh/hydraulic_model: drive/telemetry").values}
    assert {"age [s]", "age limit [s]", "rate in data time [1/s]", "rate expected [1/s]", "not a number [1]", "stuck [1]"} <= keys


def test_the_clock_jumping_back_resets_the_models_and_is_counted(recorded, graph, short_bag, listener):
    health = listener.collect(DiagnosticArray, "/diagnostics")
    estimates = listener.collect(TemperatureEstimateArray, "/ddh/temperature/estimates")
    first = raw_messages(recorded, TemperatureEstimateArray, "/ddh/temperature/estimates")[0]
    play(short_bag, *MODELS)  # the same stamps again: 20 s back
    wait_for(lambda: len(estimates) >= 400, 30.0, "estimates of the second round")
    again = next(m for m in estimates if stamp_ns(m) == stamp_ns(first))
    assert again.estimates[5].standard_deviation == pytest.approx(first.estimates[5].standard_deviation, rel=0.2)
    for node in MODELS:
        status = wait_for(
            lambda node=node: (s := diagnostics(health, f"ddh/{node}: clock")) and s.level == DiagnosticStatus.WARN and s, 5.0, node
        )
        assert int(value(status, "model restarts [1]")) >= 1
        assert graph[node].text.count("the model begins anew") == 1  # said once


def test_two_sensors_that_are_exchanged_are_left_out_once_they_are_told(paper_cycle_bag, listener, tmp_path):
    """The winding's and the tank's: the live estimate comes back to where the winding is, with a band that says that nobody reads it."""
    sound = read_recording(paper_cycle_bag).between(0.0, 90.0)
    read = sound.temperatures
    swapped = replace(sound, temperatures={**read, "motor_winding": read["tank_oil"], "tank_oil": read["motor_winding"]})
    estimates = listener.collect(TemperatureEstimateArray, "/swapped/temperature/estimates")
    status = listener.collect(DiagnosticArray, "/diagnostics")
    with models("/swapped") as nodes:
        play(write_recording(tmp_path / "swapped", swapped), *MODELS, namespace="/swapped")
        said = nodes["temperature_fusion"].says("look exchanged")
        assert "temperature/motor_winding and temperature/tank_oil look exchanged" in said and "neither is used" in said
        end = np.rint((sound.epoch_ns * 1e-9 + 89.0) * 1e9)
        wait_for(lambda: estimates and stamp_ns(estimates[-1]) > end, 20.0, "the last estimate")
        truth, at = replay(sound, load_rig()), NODES.index("end_winding")
        last = estimates[-1].estimates[at]
        off = abs(last.temperature + 273.15 - truth.fused[-1, at])
        assert off < 2.0 * last.standard_deviation and last.standard_deviation > 1.0
        assert np.isnan(last.measured)
        wait_for(lambda: "look exchanged" in (diagnostics(status, "swapped/temperature_fusion: estimate") or DiagnosticStatus()).message,
                 10.0, "a warning in /diagnostics")


def test_a_current_ten_times_too_large_is_told_and_the_winding_stays_known(paper_cycle_bag, listener, tmp_path):
    sound = read_recording(paper_cycle_bag).between(0.0, 8.0)
    tenfold = np.where(np.isin(sound.drive.fields, ("current", "torque", "electrical_power")), 10.0, 1.0)
    wrong = replace(sound, drive=replace(sound.drive, values=sound.drive.values * tenfold))
    estimates = listener.collect(TemperatureEstimateArray, "/tenfold/temperature/estimates")
    status = listener.collect(DiagnosticArray, "/diagnostics")
    with models("/tenfold") as nodes:
        play(write_recording(tmp_path / "tenfold", wrong), *MODELS, namespace="/tenfold")
        said = nodes["temperature_fusion"].says("pressures and speed ask of the shaft")
        assert "drive/telemetry current is 9.8 times" in said or "drive/telemetry current is 10 times" in said
        wait_for(lambda: estimates and stamp_ns(estimates[-1]) > sound.epoch_ns + 7_000_000_000, 20.0, "the last estimate")
        last, truth = estimates[-1].estimates[NODES.index("end_winding")], replay(sound, load_rig())
        assert abs(last.temperature + 273.15 - truth.fused[-1, NODES.index("end_winding")]) < last.standard_deviation
        wait_for(lambda: "ask of the shaft" in (diagnostics(status, "tenfold/temperature_fusion: estimate") or DiagnosticStatus()).message,
                 10.0, "a warning in /diagnostics")


def test_models_that_missed_what_drives_them_are_brought_back_to_what_is_fused(paper_cycle_bag, listener, tmp_path):
    """25 s of drive and hydraulics are missing, as to a process that was stopped: the winding is 3 K warmer than the models then know."""
    whole = read_recording(paper_cycle_bag).between(0.0, 80.0)
    missing = whole
    for topic in ("drive/telemetry", "hydraulics/telemetry"):
        missing = without_samples(missing, topic, 20.0, 45.0)
    truth, result = replay(whole, load_rig()), replay(missing, load_rig())
    namespace, at = "/missed", NODES.index("end_winding")
    predictions = listener.collect(HydraulicState, f"{namespace}/hydraulics/prediction")
    motor = listener.collect(MotorThermalState, f"{namespace}/motor/thermal_state")
    with models(namespace) as nodes:
        play(write_recording(tmp_path / "missing", missing), *MODELS, namespace=namespace, rate=8.0)
        end = whole.epoch_ns + 79_000_000_000
        for messages in (predictions, motor):
            wait_for(lambda messages=messages: messages and stamp_ns(messages[-1]) > end, 60.0, "the last interval")
        for name, messages in (("hydraulic_model", predictions), ("machine_thermal", motor)):
            last = messages[-1].temperature[at] + ZERO_CELSIUS
            assert abs(last - truth.free_temperature[-1, at]) < 1.0 and abs(last - result.free_temperature[-1, at]) < 0.3
            assert nodes[name].text.count("its temperatures follow temperature/estimates") == 1


def test_without_temperature_sensors_the_models_carry_the_estimate(graph, short_bag, listener):
    estimates = listener.collect(TemperatureEstimateArray, "/ddh/temperature/estimates")
    play(short_bag, *MODELS, topics=["drive/*", "hydraulics/*", "rig"])
    wait_for_quiet()
    last = estimates[-1]
    assert stamp_ns(last) - stamp_ns(estimates[0]) > 19e9
    assert all(np.isnan(e.measured) for e in last.estimates)
    assert all(0.5 < e.standard_deviation < 30.0 and np.isfinite(e.temperature) for e in last.estimates)


def test_with_sensors_alone_the_fusion_still_estimates(short_bag, listener):
    estimates = listener.collect(TemperatureEstimateArray, "/bare/temperature/estimates")
    with NodeProcess("temperature_fusion", "/bare", flush_after=0.5) as fusion:
        play(short_bag, "temperature_fusion", namespace="/bare", topics=["temperature/*"])
        wait_for(lambda: len(estimates) >= 390, 30.0, "estimates")
        fusion.stop()
    tank = estimates[-1].estimates[NODES.index("tank_oil")]
    assert abs(tank.temperature - tank.measured) < 1.0 and np.isnan(tank.predicted)
    assert 0.0 < tank.standard_deviation < 1.0


def test_the_estimate_survives_a_restart(short_recording, listener, tmp_path):
    state, said, deviation = tmp_path / "state", [], []
    for start, stop in ((0.0, 10.0), (10.0, 20.0)):
        bag = write_recording(tmp_path / f"from_{start:g}", short_recording.between(start, stop))
        estimates = listener.collect(TemperatureEstimateArray, "/kept/temperature/estimates")
        with NodeProcess("temperature_fusion", "/kept", flush_after=0.5, model_timeout=0.5, state_file=str(state)) as fusion:
            play(bag, "temperature_fusion", namespace="/kept", topics=["temperature/*", "rig"])
            wait_for(lambda e=estimates: len(e) >= 190, 30.0, "estimates")
            fusion.stop()
            said.append(fusion.text)
        tank = NODES.index("tank_oil")
        deviation += [estimates[0].estimates[tank].standard_deviation, estimates[-1].estimates[tank].standard_deviation]
    (first,) = (line for line in said[0].splitlines() if "no state yet" in line)
    assert "INFO" in first and "WARN" not in first
    assert "going on from the state of 0 s before" in said[1]
    assert deviation[2] < 1.5 * deviation[1] < deviation[0]  # warm start: no wider than it was left, give or take the pause


def test_a_state_of_another_rig_than_the_file_names_is_not_used(short_recording, short_bag, tmp_path):
    """Nobody announces which rig this is."""
    state = TemperatureFusion(load_rig(), 0.05, ambient=295.0).state
    save_state(tmp_path / "state", state, "crane_1", short_recording.epoch_ns - 1_000_000_000)
    (tmp_path / "crane_2.yaml").write_text("rig_id: crane_2\n")
    given = {"flush_after": 0.5, "model_timeout": 0.5, "state_file": str(tmp_path / "state"), "rig": str(tmp_path / "crane_2.yaml")}
    with NodeProcess("temperature_fusion", "/other", **given) as fusion:
        play(short_bag, "temperature_fusion", namespace="/other", topics=["temperature/*"])
        fusion.says("is of rig 'crane_1', this is 'crane_2'; not used")
        fusion.stop()


def test_a_model_begins_from_what_is_read_when_another_rig_is_announced(paper_cycle_bag, listener, tmp_path):
    warm = read_recording(paper_cycle_bag).between(0.0, 90.0)  # longer than it takes on a busy machine
    for sensor in ("motor_winding", "motor_housing"):
        warm = with_value(warm, f"temperature/{sensor}", "temperature", 60.0 + ZERO_CELSIUS, 0.0)
    bag = write_recording(tmp_path / "warm", warm)
    states = listener.collect(MotorThermalState, "/swapped/motor/thermal_state")
    health = listener.collect(DiagnosticArray, "/diagnostics")
    with NodeProcess("machine_thermal", "/swapped", flush_after=0.5) as model:
        rig = listener.node.create_publisher(RigInfo, "/swapped/rig", LATCHED)
        given = {"bag": str(bag), "rate": 2.0, "wait_for_nodes": ["machine_thermal"], "topics": ["drive/telemetry", "temperature/*"]}
        with NodeProcess("bag_player", "/swapped", **given) as player:
            heard = warm.epoch_ns
            for number in range(4):
                rig.publish(RigInfo(rig_id=f"rig_{number}", oil_grade="ISO VG 32", payload_mass=149.5))
                model.says(f"rig rig_{number}")  # the first time once it has started
                # what it told before comes late on a busy machine; what is of so much later it told after it began, which takes 3 s of data
                wait_for(lambda begun=heard + 6_000_000_000: states and stamp_ns(states[-1]) > begun, 60.0, "states")
                heard = stamp_ns(states[-1])
            wait_for(lambda: (told := diagnostics(health, "swapped/machine_thermal: rig")) and "of the rig changed" in told.message
                     and "do two machines publish on /swapped/rig?" in told.message, 10.0, "the exchange of rigs")
            for name in ("rig_2", "rig_3", "rig_2", "rig_3"):
                rig.publish(RigInfo(rig_id=name, oil_grade="ISO VG 32", payload_mass=149.5))
            player.stop()
        listener.withdraw(rig)
        model.stop()
    housing = np.array([state.temperature[list(state.nodes).index("housing")] for state in states])
    assert model.text.count("it begins anew") == 3
    assert (abs(housing - 60.0) < 2.0).all(), housing.min()


@pytest.mark.parametrize(("told", "words"), [("rig_000", ""), ("rig_9", "rig 'rig_9' was announced, this was 'rig_000'; it begins anew")])
def test_a_rig_that_is_told_late_changes_nothing_unless_it_is_another(told, words, short_recording, listener, tmp_path):
    warm = TemperatureFusion(load_rig())
    state = warm.state
    state.covariance[:] *= 1e-4
    save_state(tmp_path / "state", state, "rig_000", short_recording.epoch_ns - 1_000_000_000)
    namespace, tank = f"/late_{told}", NODES.index("tank_oil")
    estimates = listener.collect(TemperatureEstimateArray, f"{namespace}/temperature/estimates")
    parts = [write_recording(tmp_path / f"{a:g}", short_recording.between(a, b)) for a, b in ((0.0, 8.0), (8.0, 12.0))]
    given = {"flush_after": 0.5, "model_timeout": 0.5, "state_file": str(tmp_path / "state")}
    with NodeProcess("temperature_fusion", namespace, **given) as fusion:
        play(parts[0], "temperature_fusion", namespace=namespace, topics=["temperature/line_a"])
        wait_for(lambda: len(estimates) >= 120, 30.0, "estimates")
        before = estimates[-1].estimates[tank].standard_deviation
        rig = listener.node.create_publisher(RigInfo, f"{namespace}/rig", LATCHED)
        rig.publish(RigInfo(rig_id=told, oil_grade="ISO VG 32", payload_mass=149.5))
        fusion.says(f"rig {told}")
        count = len(estimates)
        play(parts[1], "temperature_fusion", namespace=namespace, topics=["temperature/line_a"])
        wait_for(lambda: len(estimates) >= count + 60, 30.0, "further estimates")
        after = estimates[-1].estimates[tank].standard_deviation
        listener.withdraw(rig)
        fusion.stop()
    assert "going on from the state of" in fusion.text
    assert ("begins anew" in fusion.text) == bool(words) and words in fusion.text
    assert (after > 3.0 * before) == bool(words), (before, after)


def test_telemetry_that_a_paused_player_holds_is_not_missed(graph, short_bag, listener):
    health = listener.collect(DiagnosticArray, "/diagnostics")

    def of_drive(level):
        return (s := diagnostics(health, "held/machine_thermal: drive/telemetry")) and s.level == level and s

    given = {"bag": str(short_bag), "paused": True, "exit_at_end": False}
    with NodeProcess("machine_thermal", "/held") as model:
        wait_for(lambda: of_drive(DiagnosticStatus.ERROR), 30.0, "the input to be missed")
        with NodeProcess("bag_player", "/held", **given) as player:
            status = wait_for(lambda: of_drive(DiagnosticStatus.OK), 20.0, "the pause to be known")
            assert status.message == "the player is paused"
            player.stop()
        wait_for(lambda: of_drive(DiagnosticStatus.ERROR), 20.0, "the player to be gone")
        model.stop()


def test_two_publishers_on_one_topic_are_named(graph, listener):
    from ddh_msgs.msg import DriveTelemetry

    health = listener.collect(DiagnosticArray, "/diagnostics")
    words = "2 publishers on /ddh/drive/telemetry, their messages are mixed"  # more while one that just ended is still counted
    made = [listener.node.create_publisher(DriveTelemetry, "/ddh/drive/telemetry", 10) for _ in range(2)]
    try:
        status = wait_for(lambda: _with(health, "ddh/machine_thermal: drive/telemetry", words), 30.0, words)
        assert status.level in (DiagnosticStatus.WARN, DiagnosticStatus.ERROR) and value(status, "publishers [1]") == "2"
        wait_for(lambda: _with(health, "ddh/hydraulic_model: drive/telemetry", words), 30.0, words)
    finally:
        for publisher in made:
            listener.withdraw(publisher)


def test_bad_input_is_named_in_log_and_diagnostics(graph, short_recording, listener, tmp_path):
    health = listener.collect(DiagnosticArray, "/diagnostics")
    estimates = listener.collect(TemperatureEstimateArray, "/ddh/temperature/estimates")
    bad = with_value(short_recording, "temperature/line_a", "temperature", float("nan"), 5.0, 15.0)
    bad = with_value(bad, "drive/telemetry", "speed", 1e6, 8.0, 9.0)
    bad = with_value(bad, "hydraulics/telemetry", "pressure_rod_side", 4.1e7, 8.0, 8.1)
    bad = with_stuck_sensor(bad, "temperature/pump_1_case", "temperature", 2.0)
    bad = with_wrong_unit(bad, "hydraulics/telemetry", "pressure_piston_side", 1e-5)
    bad = with_clock_jump(bad, 16.0, -10.0)
    play(write_recording(tmp_path / "bad", bad), *MODELS)
    wait_for_quiet()
    pressure = wait_for(lambda: _with(health, "ddh/hydraulic_model: hydraulics/telemetry", "unit suspect"), 30.0, "unit suspect")
    assert pressure.level == DiagnosticStatus.ERROR
    for name, words in (
        ("ddh/temperature_fusion: temperature/line_a", "not a number"),
        ("ddh/machine_thermal: drive/telemetry", "out of range"),
        ("ddh/temperature_fusion: temperature/pump_1_case", "stuck"),
    ):
        assert _with(health, name, words), f"{name}: {words}"
    said = graph["hydraulic_model"].text
    assert said.count("/ddh/hydraulics/telemetry pressure_piston_side looks as if given in bar") == 1
    assert "/ddh/drive/telemetry speed reads 1e+06 rad/s" in said
    assert "/ddh/hydraulics/telemetry pressure_rod_side reads 4.1e+07 Pa" in said and "the sensor's full scale is 4e+07 Pa" in said
    assert all(np.isfinite(e.temperature) for m in estimates for e in m.estimates)


def test_temperatures_that_are_all_in_degf_are_told_together_and_none_is_fused(listener, paper_cycle_bag, tmp_path):
    """Those within their range in that unit too: the estimate is of the models alone, near 23 degC and not near 73."""
    fahrenheit = read_recording(paper_cycle_bag).between(0.0, 20.0)
    for sensor in TEMPERATURE_SENSORS:
        fahrenheit = with_wrong_unit(fahrenheit, f"temperature/{sensor}", "temperature", 1.8, ZERO_CELSIUS + 32.0 - 1.8 * ZERO_CELSIUS)
    estimates = listener.collect(TemperatureEstimateArray, "/warm/temperature/estimates")
    health = listener.collect(DiagnosticArray, "/diagnostics")
    with models("/warm") as nodes:
        play(write_recording(tmp_path / "fahrenheit", fahrenheit), *MODELS, namespace="/warm")
        end = (fahrenheit.epoch_ns * 1e-9 + 19.0) * 1e9
        wait_for(lambda: estimates and stamp_ns(estimates[-1]) > end, 30.0, "the last estimate")
        assert max(e.temperature for e in estimates[-1].estimates) < 60.0 and max(e.predicted for e in estimates[-1].estimates) < 60.0
        assert not any(np.isfinite(e.measured) for e in estimates[-1].estimates)
        for sensor in set(TEMPERATURE_SENSORS) - {"ambient"}:
            wait_for(lambda s=sensor: _with(health, f"warm/temperature_fusion: temperature/{s}", "looks as if given in degF"), 20.0, sensor)
            line = nodes["temperature_fusion"].says(f"/warm/temperature/{sensor} temperature looks as if given in degF")
            assert "it begins with 7" in line and "not used" in line


def _with(messages, name, words):
    """Newest status of that name whose message holds these words."""
    for message in reversed(messages):
        for status in message.status:
            if status.name == name and words in status.message:
                return status
    return None


def test_two_rigs_on_one_network_stay_apart(graph, short_bag, listener):
    ours = listener.collect(MotorThermalState, "/ddh/motor/thermal_state")
    theirs = listener.collect(MotorThermalState, "/site/rig_b/motor/thermal_state")
    with NodeProcess("machine_thermal", "/site/rig_b", flush_after=0.5, stale_after=0.5) as other:
        play(short_bag, "machine_thermal", namespace="/site/rig_b")
        wait_for(lambda: len(theirs) >= 350, 30.0, "states of the other rig")
        other.stop()
    assert not ours


def test_every_status_has_its_place_in_the_tree_of_rqt(recorded, repo_root):
    """What no analyzer takes would stand under "Other"."""
    parameters = yaml.safe_load((repo_root / "ddh_twin_py/config/layouts/diagnostic_aggregator.yaml").read_text())

    def prefixes(node):
        if isinstance(node, dict):
            yield from node.get("startswith", ())
            for child in node.values():
                yield from prefixes(child)

    begins = tuple(prefixes(parameters))
    names = {status.name for message in raw_messages(recorded, DiagnosticArray, "/diagnostics") for status in message.status}
    assert names and not {name for name in names if not name.startswith(begins)}
    machine = tuple(prefixes(parameters["analyzers"]["ros__parameters"]["machine"]))
    streams = {name for name in names if name.split(": ")[1].startswith(("drive/", "hydraulics/telemetry"))}
    assert streams and all(name.startswith(machine) for name in streams)
