"""A described rig of one file: a block that an input heats and that cools to its surroundings, read by one sensor."""

import numpy as np
from ddh_twin_py.gap.effect import Effect, added, fixed
from ddh_twin_py.real_rigs.description import Description, Parameter
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.run import Run
from ddh_twin_py.real_rigs.signals import signal

STEP, NOISE = 1.0, 0.02


def effect(name, domain, parameter, unit, field, step, lowest=-np.inf):
    return Effect(name, name.split(".")[0], domain, parameter, unit, fixed(0.0), (added(field),), step, lowest, about="Something acts.")


DESCRIPTION = Description(
    "block", "made up", (Parameter("gain", 1.0, 0.1, "K/W", "guess", 0.1), Parameter("lag", 40.0, 8.0, "s", "guess", 5.0)),
    {"offset": 0.0, "bend": 0.0, "draught": 0.0},
    (effect("sensor.offset", "measurement", "offset", "K", "offset", 0.1),
     effect("sensor.bend", "measurement", "bend", "1/K", "bend", 0.02),
     effect("air.draught", "thermal", "rise", "1", "draught", 0.1, 0.0)),
    {"temperature": ("block", "thermal")},
)


class Block(Run):
    def __init__(self, command, measured, held_share=0.25, name="block.csv"):
        self.name, self.command = name, command
        time = STEP * np.arange(command.size)
        end = (1.0 - held_share) * time[-1]
        self.signals = {"temperature": signal(time, measured, NOISE, "K", 5.0, used_until=end, held_from=end if held_share else np.inf)}

    def _level(self, p):
        out, x = np.empty(self.command.size), 0.0
        for i, u in enumerate(self.command):
            out[i] = x
            lag = p["lag"] / (1.0 + p["draught"] * (x > 1.0))
            x += STEP / lag * (p["gain"] * u - x)
        return out

    def predict(self, record):
        p = record[0]
        x = self._level(p)
        return {"temperature": x + p["offset"] + p["bend"] * x**2}

    def variables(self, record):
        return {"warmth, K": (STEP * np.arange(self.command.size), self._level(record[0]))}


def block(acting=(), theta=(0.5, -0.5), seed=0, size=1600, held=True):
    """A model of the block on data of itself with effects acting."""
    rng = np.random.default_rng(seed)
    command = np.repeat(rng.uniform(0.0, 2.0, size // 40), 40)
    blank = Block(command, np.zeros(command.size))
    record = RigModel(DESCRIPTION, [blank]).record(0, np.asarray(theta), acting)
    true = blank.predict(record)["temperature"]
    return RigModel(DESCRIPTION, [Block(command, true + rng.normal(0.0, NOISE, true.size), 0.25 if held else 0.0)])
