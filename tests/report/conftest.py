"""A replay result with known differences, made of arrays alone."""

import numpy as np
import pytest
from ddh_twin_py.estimation.fusion.result import Innovation
from ddh_twin_py.estimation.replay_result import ReplayResult, SensorComparison
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE
from ddh_twin_py.physics.thermal_network import N, NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Finding, Recording, RigInfo, temperature_stream

INTERVALS = 400
SIGNALS = (
    "speed", "torque", "current", "voltage", "electrical_power",
    "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity",
)


@pytest.fixture
def result() -> ReplayResult:
    rig = load_rig()
    time = 0.05 * np.arange(1, INTERVALS + 1)
    measured, soft, free = (np.zeros(INTERVALS, dtype) for dtype in (MEASURED_DTYPE, OPERATING_DTYPE, OPERATING_DTYPE))
    for i, name in enumerate(SIGNALS):
        measured[name] = np.sin(time + i) * 10.0 ** (i % 3)
        # the free run is off by half the noise, the soft sensor by a quarter
        kind = "pressure" if name.startswith("pressure") else name
        free[name] = measured[name] + 0.5 * rig.sensors[kind].noise
        soft[name] = measured[name] + 0.25 * rig.sensors[kind].noise
    soft["loss_pump_1"], free["loss_pump_1"] = 100.0, 90.0
    soft["electrical_power"] += 200.0 - soft["electrical_power"].mean()
    temperature = np.full((INTERVALS, N), 300.0)
    when = np.arange(40) * 0.5
    sensors, innovations = {}, []
    for name, node, off in (("tank_oil", "tank_oil", 0.05), ("motor_winding", "end_winding", 0.3)):
        warm = 300.0 + 0.1 * when
        sensors[name] = SensorComparison(
            node, when, warm, warm + off, warm + 0.02, np.full(40, 0.2), rig.sensors["temperature"].noise, True,
            np.searchsorted(time, when),
        )
        innovations += [Innovation(i, name, 300.1, 300.0, 0.1, i > 0) for i in range(40)]
    recording = Recording(
        "bags/odd </script> & name", 1_772_000_000_000_000_000, RigInfo("rig_007", "ISO VG 32", 149.5), None, None,
        {name: temperature_stream(when, c.measured) for name, c in sensors.items()},
        [Finding("warning", "bags/x", "/ddh/drive/telemetry", "speed", float("nan"), 3,
                 "bags/x: topic /ddh/drive/telemetry field speed is NaN in 3 samples <first at 1 s>")],
        "/ddh",
    )
    assert [NODES.index(c.node) for c in sensors.values()]
    return ReplayResult(
        recording, rig, time, measured, soft, free, temperature, temperature + 1.0, np.full((INTERVALS, N), 0.3),
        sensors, innovations, {"hydraulic_model": 0.5, "temperature_fusion": 0.25},
    )
