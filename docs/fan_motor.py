"""A rig described from nothing: a DC motor that turns a fan, its speed and current read 100 times a second.

    python docs/fan_motor.py

Data are made by the model itself, with a fault that the diagnosis is not told of. Take the file as a beginning for a rig of your own.
"""

import numpy as np
from ddh_twin_py.gap.effect import Effect, added, fixed, scaled
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.real_rigs.controls import on_simulated
from ddh_twin_py.real_rigs.description import Description, Parameter
from ddh_twin_py.real_rigs.diagnose import Outcome, found_by, rounds
from ddh_twin_py.real_rigs.next_test import DescribedTest
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.run import Run
from ddh_twin_py.real_rigs.signals import signal

STEP = 0.01  # s
NOISE = {"speed": 2.0, "current": 0.05}  # rad/s, A
HELD_SHARE = 0.25

PARAMETERS = (
    Parameter("resistance", 1.2, 0.1, "ohm", "data sheet, winding from cold to warm", 0.1),
    Parameter("constant", 0.05, 0.001, "V*s/rad", "data sheet, measured by its maker", 1e-3),
    Parameter("inertia", 2e-4, 4e-5, "kg*m2", "drawing", 1e-5),
    Parameter("fan", 2e-6, 6e-7, "N*m*s2", "fans of this size", 0.0),
)
NEUTRAL = {"dry": 0.0, "loose": 0.0, "speed_scale": 1.0, "current_offset": 0.0}


def effect(id, domain, parameter, unit, law, step, lowest, highest, about, equation, reference=0.0) -> Effect:
    return Effect(id, id.split(".")[0], domain, parameter, unit, fixed(reference), (law,), step, lowest, highest, about, equation)


EFFECTS = (
    effect("bearing.dry_friction", "mechanical", "torque", "N*m", added("dry"), 2e-3, 0.0, 0.05, "The bearing is dry.", "M = M0 - T"),
    effect("terminal.contact", "electrical", "voltage", "V", added("loose"), 0.1, 0.0, 3.0, "A contact drops voltage.", "U = U0 - V"),
    effect("speed_sensor.scale", "measurement", "scale", "1", scaled("speed_scale"), 0.02, -0.3, 0.3, "The speed is read too high or low.",
           "y = w (1 + d)", 1.0),
    effect("current_sensor.offset", "measurement", "offset", "A", added("current_offset"), 0.05, -2.0, 2.0, "The current has a zero error.",
           "y = i + d"),
)
DESCRIPTION = Description("fan", "made by its own model", PARAMETERS, NEUTRAL, EFFECTS,
                          {"speed": ("bearing", "mechanical"), "current": ("winding", "electrical")}, cut=3.0)


@kernel
def _run(p, voltage, speed, current):
    w = 0.0
    for k in range(voltage.size):
        i = max(voltage[k] - p["loose"] - p["constant"] * w, 0.0) / p["resistance"]
        speed[k], current[k] = w, i
        torque = p["constant"] * i - p["fan"] * w * w - (p["dry"] if w > 0.0 else 0.0)
        w = max(w + STEP / p["inertia"] * torque, 0.0)


class Fan(Run):
    """One record, simulated from the voltage alone; signals ``speed``, rad/s, and ``current``, A."""

    def __init__(self, name: str, voltage: np.ndarray, read: dict[str, np.ndarray], held_share: float = 0.0) -> None:
        self.name, self.voltage, self.time = name, voltage, STEP * np.arange(voltage.size)
        end = (1.0 - held_share) * self.time[-1]
        kind = np.digitize(voltage, (8.0, 16.0))  # samples that a flaw of the model would shift together
        self.signals = {key: signal(self.time, read[key], NOISE[key], unit, 0.1, kind, end, end if held_share else np.inf)
                        for key, unit in (("speed", "rad/s"), ("current", "A"))}

    def predict(self, record: np.ndarray) -> dict[str, np.ndarray]:
        speed, current = np.empty(self.voltage.size), np.empty(self.voltage.size)
        _run(record[0], self.voltage, speed, current)
        return {"speed": record["speed_scale"][0] * speed, "current": current + record["current_offset"][0]}

    def variables(self, record: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        return {"speed, rad/s": (self.time, self.predict(record)["speed"]), "voltage, V": (self.time, self.voltage)}


def blank(name: str, voltage: np.ndarray) -> Fan:
    """A record of a voltage, V, (n,), that nothing was read in."""
    return Fan(name, voltage, dict.fromkeys(NOISE, np.zeros(voltage.size)))


def recorded(acting=(), seed: int = 0) -> Fan:
    """A made record: parameters that are not the sheet's, effects (effect, law, departure), noise."""
    rng = np.random.default_rng(seed)
    voltage = np.repeat(rng.uniform(4.0, 24.0, 30), 200)
    run = blank("fan.csv", voltage)
    true = run.predict(RigModel(DESCRIPTION, [run]).record(0, np.array([0.5, -0.3, 0.4, -0.6]), acting))
    return Fan("fan.csv", voltage, {key: true[key] + rng.normal(0.0, NOISE[key], voltage.size) for key in true}, HELD_SHARE)


def diagnosed(run: Fan) -> list[Outcome]:
    """Diagnose; build in what is believed; diagnose again."""
    stopped = blank("test", np.repeat([0.0, 12.0, 0.0, 24.0, 0.0], 400))
    return rounds(RigModel(DESCRIPTION, [run], tests=[DescribedTest("Start the motor from rest to 12 and 24 V.", stopped)]))


if __name__ == "__main__":
    for outcome in (outcomes := diagnosed(recorded([(EFFECTS[0], 0, 0.02)]))):
        print(outcome.diagnosis.sentence)
        print(outcome.diagnosis.report["next_test"] or outcome.why_no_test())
    last = outcomes[-1]
    print("built in:", ", ".join(found_by(outcomes)) or "nothing")
    for p in last.model.fitted_parameters(last.plain.theta, np.ones(last.model.size)):
        print(f"{p.name}: {p.value:.4g} {p.unit}")
    print(on_simulated(last.model, last.plain.theta))
