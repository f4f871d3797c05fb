"""Small sets in the format of the real ones, made by the models themselves, with an effect in them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from ddh_twin_py.real_rigs.cascaded_tanks import model as tanks
from ddh_twin_py.real_rigs.cascaded_tanks.recordings import TankRecord
from ddh_twin_py.real_rigs.emps import model as emps
from ddh_twin_py.real_rigs.emps.recordings import PERIOD, STEP, EmpsRecord
from ddh_twin_py.real_rigs.rig_model import RigModel
from scipy.io import savemat

GAINS = {"force_gain": 35.15, "position_gain": 160.18, "velocity_gain": 243.45}


def effect_of(description, name):
    return next(effect for effect in description.effects if effect.id == name)


def emps_record(acting=(), pulses=0.0, seed=0, periods=4) -> EmpsRecord:
    """Forward and backward at speeds that differ, ``periods`` times; ``pulses``: V, while the reference moves fast."""
    rng = np.random.default_rng(seed)
    time = STEP * np.arange(periods * PERIOD)
    phase = 2.0 * np.pi * (time % (STEP * PERIOD)) / (STEP * PERIOD)
    reference = 0.12 * (1.0 - np.cos(phase)) * (0.7 + 0.3 * np.cos(3.0 * phase))
    command = np.where(np.sin(7.0 * phase) > 0.6, pulses, 0.0)
    blank = EmpsRecord(Path("blank.mat"), time, reference, reference.copy(), np.zeros(time.size), GAINS["force_gain"] * command, **GAINS)
    axis = emps.Axis(blank, 0.3)
    position, force = axis.simulate(RigModel(emps.DESCRIPTION, [axis]).record(0, np.array([-0.2, 0.1, 0.1]), acting))
    noisy = force + rng.normal(0.0, 0.3, force.size)
    return replace(blank, position=position, command=noisy / GAINS["force_gain"])


def write_emps(folder: Path, acting=()) -> Path:
    """``folder/emps`` with both files."""
    (folder / "emps").mkdir(parents=True, exist_ok=True)
    for name, pulses, seed in (("DATA_EMPS.mat", 0.0, 0), ("DATA_EMPS_PULSES.mat", 2.0, 1)):
        record = emps_record(acting, pulses, seed)
        values = {"t": record.time, "qg": record.reference, "qm": record.position, "vir": record.command, "gtau": record.force_gain,
                  "kp": record.position_gain, "kv": record.velocity_gain}
        if pulses:
            values["pulses_N"] = record.pulses / record.force_gain
        savemat(folder / "emps" / name, {key: np.reshape(value, (-1, 1)) for key, value in values.items()})
    return folder


def tank_record(acting=(), seed=0, size=1024, noise=0.1) -> TankRecord:
    """A pump that changes every 160 s and is now and then strong enough to fill the upper tank above 10 V."""
    rng = np.random.default_rng(seed)
    pump = np.repeat(np.clip(rng.normal(2.8, 1.4, -(-size // 40)), 0.3, 6.0), 40)[:size]
    blank = tanks.Tanks(TankRecord("blank", pump, np.zeros(size)))
    record = RigModel(tanks.DESCRIPTION, [blank]).record(0, np.array([0.1, 0.2, -0.3, 0.2, 0.1, 0.0]), acting)
    return TankRecord("made", pump, blank.predict(record)["level"] + rng.normal(0.0, noise, size))


def write_tanks(folder: Path, acting=()) -> Path:
    """``folder/cascaded_tanks`` with its file."""
    (folder / "cascaded_tanks").mkdir(parents=True, exist_ok=True)
    first, test = tank_record(acting, 0), tank_record(acting, 1)
    rows = ['"uEst","uVal","yEst","yVal","Ts",']
    rows += [f"{a:.6g},{b:.6g},{c:.6g},{d:.6g},{'4' if i == 0 else ''}," for i, (a, b, c, d) in enumerate(
        zip(first.pump, test.pump, first.level, test.level, strict=True))]
    (folder / "cascaded_tanks" / "dataBenchmark.csv").write_text("\n".join(rows) + "\n")
    return folder
