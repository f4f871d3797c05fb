"""A rig that is not the direct driven unit: a first-order flow loop with two sensors, as `gap.model.Model`."""

import numpy as np
from ddh_twin_py.estimation.fitting.binning import by_cycle, cycle_of
from ddh_twin_py.estimation.fitting.experiment import Signal
from ddh_twin_py.gap.effect import Effect, added, fixed, scaled, value_of
from ddh_twin_py.gap.witnesses import Witnesses

STEP, NOISE, DEVIATION = 0.05, 0.02, np.array([0.1, 0.1, 0.05])
RECORD = np.array([(1.0, 0.8, 0.0, 0.0)], dtype=[("gain", float), ("lag", float), ("zero", float), ("other_zero", float)])


def effect(name, domain, parameter, unit, reference, law, step):
    return Effect(name, name.split(".")[0], domain, parameter, unit, reference, (law,), step, -0.5, 5.0)


EFFECTS = [
    effect("valve.gain", "hydraulic", "gain", "1", fixed(1.0), scaled("gain"), 0.05),
    effect("valve.lag", "mechanical", "time_constant", "s", value_of("lag"), added("lag"), 0.05),
    effect("meter.offset", "measurement", "offset", "m3/s", fixed(0.0), added("other_zero"), 0.02),
]


class FirstOrder:
    """lag dx/dt = gain u - x, read as x + zero and x + other_zero; deviations of gain, lag and zero are its parameters.

    The first recording is the loop as built; in the second, which is longer, the true effects act too.
    """

    difference = 0.01
    witnesses = Witnesses()

    def __init__(self, theta, acting=(), seed=0, seconds=(60.0, 90.0)):
        rng = np.random.default_rng(seed)
        self.size, self.altered, self.signals = 3, [False, True], []
        self._command = [np.repeat(rng.choice([-1.0, 0.0, 1.0], int(s / 3.0)), round(3.0 / STEP)) for s in seconds]
        for number, command in enumerate(self._command):
            time = STEP * np.arange(command.size)
            binning = by_cycle(cycle_of(command, STEP), time, np.ones(time.size, dtype=bool))
            true = self.run_one(number, np.asarray(theta), acting)
            read = {name: y + rng.normal(0.0, NOISE, y.size) for name, y in true.items()}
            self.signals.append({name: Signal(time, y, NOISE, "m3/s", binning) for name, y in read.items()})

    def record(self, number, theta, acting=()):
        record = RECORD.copy()
        for name, deviation in zip(("gain", "lag", "zero"), theta * DEVIATION, strict=True):
            record[name] += deviation
        for effect, law, x in acting if self.altered[number] else ():
            effect.laws[law](record, x)
        return record

    def within(self, theta):
        return np.clip(theta, -4.0, 4.0)

    def run(self, theta, acting=()):
        return [self.run_one(number, theta, acting) for number in range(2)]

    def run_one(self, number, theta, acting=(), roughly=False):
        p = self.record(number, theta, acting)[0]
        x, out, keep = 0.0, np.empty(self._command[number].size), np.exp(-STEP / p["lag"])
        for i, u in enumerate(self._command[number]):
            out[i] = x
            x = keep * x + (1.0 - keep) * p["gain"] * u
        return {"flow": out + p["zero"], "other_flow": out + p["other_zero"]}

    def begin_anew(self, theta, acting):
        return False

    def variables(self, comparisons, theta, acting=()):
        return [{} for _ in comparisons]
