"""Messages composed and parsed in bulk are those of the real serialiser."""

import numpy as np
import pytest
from ddh_twin_py.nodes.messages.conversion import (
    estimate_layout,
    hydraulic_layout,
    hydraulic_residual_layout,
    location_layout,
    motor_layout,
)
from ddh_twin_py.nodes.messages.wire import BulkParser, Layout, stamp_of
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Temperature

from ddh_msgs.msg import HydraulicState, MotorThermalState, ResidualArray, RigInfo, TemperatureEstimateArray

LAYOUTS = {
    HydraulicState: hydraulic_layout("soft_sensor"),
    MotorThermalState: motor_layout(),
    TemperatureEstimateArray: estimate_layout(),
    ResidualArray: hydraulic_residual_layout("free_run"),
    Temperature: location_layout("tank_oil"),
}
STAMPS = np.array([5, 1_772_000_000_123_456_789, -1], np.int64)


def filled(layout, rng):
    """Random values for every field of a layout, as `compose` takes them."""
    return {name: rng.normal(size=(3, count) if count else 3) for name, count in layout.columns.items()}


@pytest.mark.parametrize("message_type", LAYOUTS, ids=lambda t: t.__name__)
def test_the_real_serialiser_reads_what_was_composed(message_type):
    layout = LAYOUTS[message_type]
    values = filled(layout, np.random.default_rng(1))
    for i, data in enumerate(layout.compose(STAMPS, values)):
        message = deserialize_message(data, message_type)
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == STAMPS[i] == stamp_of(data)
        for name, value in values.items():
            owner, _, attribute = name.rpartition(".")
            found = [getattr(m, attribute) for m in getattr(message, owner)] if owner else getattr(message, attribute)
            assert np.array_equal(np.asarray(found), value[i]), name


@pytest.mark.parametrize("message_type", LAYOUTS, ids=lambda t: t.__name__)
def test_what_the_real_serialiser_wrote_is_parsed(message_type):
    layout = LAYOUTS[message_type]
    values = filled(layout, np.random.default_rng(2))
    data = [serialize_message(deserialize_message(m, message_type)) for m in layout.compose(STAMPS, values)]
    runs = BulkParser(message_type).parse(data)
    assert np.array_equal(np.concatenate([stamps for _, stamps, _ in runs]), STAMPS)
    for name, value in values.items():
        assert np.array_equal(np.concatenate([found[name] for _, _, found in runs]), value), name


def test_bools_are_carried():
    layout = LAYOUTS[HydraulicState]
    data = layout.compose(STAMPS, {"telemetry_known": np.array([True, False, True])})
    assert [deserialize_message(m, HydraulicState).telemetry_known for m in data] == [True, False, True]
    assert layout.parse(data)[1]["telemetry_known"].tolist() == [True, False, True]


def test_a_change_of_names_is_noticed():
    parser = BulkParser(HydraulicState)
    soft = LAYOUTS[HydraulicState].compose(STAMPS[:2], {})
    free = hydraulic_layout("free_run").compose(STAMPS[:2], {})
    runs = parser.parse([*soft, *free, *soft])
    modes = [example.mode for example, stamps, _ in runs for _ in stamps]
    assert modes == ["soft_sensor"] * 2 + ["free_run"] * 2 + ["soft_sensor"] * 2


def test_a_type_without_fixed_layout_is_refused():
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

    with pytest.raises(TypeError, match=r"DiagnosticStatus: field status.level is of type octet"):
        Layout(DiagnosticArray(status=[DiagnosticStatus()]))


def test_a_name_that_is_no_field_is_refused():
    with pytest.raises(KeyError):
        LAYOUTS[HydraulicState].compose(STAMPS, {"presure": 1.0})


def test_rig_info_has_a_layout_too():
    assert Layout(RigInfo(rig_id="x")).columns == {"payload_mass": 0}


@pytest.mark.parametrize("message_type", [ResidualArray, TemperatureEstimateArray], ids=lambda t: t.__name__)
def test_a_list_without_entries_has_no_values(message_type):
    (example, stamps, values), = BulkParser(message_type).parse([bytes(serialize_message(message_type()))])
    assert isinstance(example, message_type) and stamps.tolist() == [0]
    nested = {name: block.shape for name, block in values.items() if "." in name}
    assert nested and set(nested.values()) == {(1, 0)}


def test_a_message_that_another_wrote_is_read():
    """One without values is padded; a machine of the other byte order writes another layout."""
    plain = serialize_message(HydraulicState(mode="soft"))
    parser = BulkParser(HydraulicState)
    for _ in range(2):  # a layout that is new, one that is known
        (example, stamps, values), = parser.parse([plain])
        assert example.mode == "soft" and stamps.tolist() == [0] and values["temperature"].shape == (1, 0)
    words = [number.to_bytes(4, "big") for number in (7, 5, 1, 0, 2, 0x78000000, 1, 0)]  # stamp, frame_id "", rig_id "x", oil_grade ""
    (example, stamps, values), = BulkParser(RigInfo).parse([bytes(4) + b"".join(words) + np.array(149.5, ">f8").tobytes()])
    assert (example.rig_id, stamps.tolist(), values["payload_mass"].tolist()) == ("x", [7_000_000_005], [149.5])


def test_a_message_that_is_none_of_the_type_is_left_out():
    soft = LAYOUTS[HydraulicState].compose(STAMPS, {})
    for first in ([], soft[:1]):
        parser = BulkParser(HydraulicState)
        parser.parse(first)
        runs = parser.parse([soft[0][:100], *soft, b"", b"\0\1" + bytes([255]) * len(soft[0]), *soft])
        assert parser.unreadable == 3 and np.concatenate([stamps for _, stamps, _ in runs]).tolist() == [*STAMPS, *STAMPS]


def test_a_message_whose_stamp_is_none_is_left_out_and_told():
    soft = LAYOUTS[HydraulicState].compose(STAMPS, {})
    odd = soft[0][:8] + (4 * 10**9).to_bytes(4, "little") + soft[0][12:]
    for first in ([], soft[:1]):
        parser = BulkParser(HydraulicState)
        parser.parse(first)
        runs = parser.parse([*soft, odd, *soft])
        assert parser.unreadable == 1 and parser.why == "header.stamp nanosec is 4000000000, allowed are 0 to 999999999"
        assert np.concatenate([stamps for _, stamps, _ in runs]).tolist() == [*STAMPS, *STAMPS]


@pytest.mark.parametrize("unsound", [
    HydraulicState(heat_nodes=["housing"]), HydraulicState(flow=[1.0]),
    HydraulicState(temperature_nodes=["housing"], temperature=[1.0, 2.0]),
    MotorThermalState(heat_nodes=["end_winding"]), MotorThermalState(nodes=["end_winding"], temperature=[]),
], ids=repr)  # fmt: skip
def test_a_message_without_a_value_for_each_name_is_left_out(unsound):
    kind = type(unsound)
    sound = LAYOUTS[kind].compose(STAMPS, {})
    for first in ([], sound[:1]):
        parser = BulkParser(kind)
        parser.parse(first)
        runs = parser.parse([serialize_message(unsound), *sound, serialize_message(unsound), *sound])
        assert parser.unreadable == 2 and np.concatenate([stamps for _, stamps, _ in runs]).tolist() == [*STAMPS, *STAMPS]
