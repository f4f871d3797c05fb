"""Runs in the environment of FMPy: validates an FMU and steps it through a command; numbers in and out as JSON.

usage: python run_fmu.py FMU < {"starts": {name: value}, "command": [...], "step": s} > {"problems": [...], "outputs": {name: [...]}, ...}
"""

import json
import sys

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu


def slave(path, description, starts, guid=None):
    made = FMU2Slave(guid=guid or description.guid, unzipDirectory=fmpy.extract(path), instanceName="twin",
                     modelIdentifier=description.coSimulation.modelIdentifier)
    made.instantiate()
    made.setupExperiment(startTime=0.0)
    made.enterInitializationMode()
    made.setReal([reference[name] for name in starts], list(starts.values()))
    made.exitInitializationMode()
    return made


path, wanted = sys.argv[1], json.load(sys.stdin)
description = fmpy.read_model_description(path)
reference = {variable.name: variable.valueReference for variable in description.modelVariables}
names = [variable.name for variable in description.modelVariables if variable.causality == "output"]
told = {"problems": validate_fmu(path), "units": {v.name: v.unit for v in description.modelVariables}, "errors": []}

fmu = slave(path, description, wanted["starts"])
rows, before, step = [fmu.getReal([reference[name] for name in names])], 0.0, wanted["step"]
middle = len(wanted["command"]) // 2
state = None
for k, command in enumerate(wanted["command"]):
    if k == middle:
        state, kept = fmu.getFMUstate(), before
        serialised = fmu.serializeFMUstate(state)
    fmu.setReal([reference["speed_command"]], [before])
    fmu.setRealInputDerivatives([reference["speed_command"]], [1], [(command - before) / step])  # a ramp over the step
    fmu.doStep(k * step, step)
    rows.append(fmu.getReal([reference[name] for name in names]))
    before = command

fmu.setFMUstate(fmu.deSerializeFMUstate(serialised))  # back to the middle, and on again
before = kept
for k, command in enumerate(wanted["command"][middle:], middle):
    fmu.setReal([reference["speed_command"]], [before])
    fmu.setRealInputDerivatives([reference["speed_command"]], [1], [(command - before) / step])
    fmu.doStep(k * step, step)
    before = command
told["again"] = fmu.getReal([reference[name] for name in names])
told["outputs"] = {name: [row[i] for row in rows] for i, name in enumerate(names)}



def lifted(payload, slope):
    """Outputs after one interval with a payload in kg that changes by so many kg/s."""
    one = slave(path, description, {"start.pressure_piston_side": 5e5})
    one.setReal([reference["payload_mass"]], [payload])
    one.setRealInputDerivatives([reference["payload_mass"]], [1], [slope])
    one.doStep(0.0, 0.05)
    return one.getReal([reference[name] for name in names])


told["lifted"] = {"rising": lifted(150.0, 200.0), "middle": lifted(155.0, 0.0), "constant": lifted(150.0, 0.0)}

for what, act in (
    ("setting an output", lambda: fmu.setReal([reference["speed"]], [1.0])),
    ("no payload", lambda: slave(path, description, {"payload_mass": 0.0})),
    ("degrees Celsius", lambda: slave(path, description, {"ambient_temperature": 23.0})),
    ("a leak that runs backwards", lambda: slave(path, description, {"pump_1.leakage": -1e-12})),
    ("a rod beyond its stroke", lambda: slave(path, description, {"start.rod_position": -0.1})),
    ("a pressure beyond all", lambda: slave(path, description, {"start.pressure_piston_side": 1e9})),
    ("a payload that falls below none", lambda: lifted(1.0, -100.0)),
    ("another GUID", lambda: slave(path, description, {}, guid="{0}")),
):
    try:
        act()
    except Exception:
        told["errors"].append(what)
plain = fmpy.simulate_fmu(path, stop_time=5.0, output_interval=0.1, start_values={"speed_command": 20.0})
told["plain"] = {name: float(plain[name][-1]) for name in ("rod_velocity", "time", "temperature.tank_oil")}
json.dump(told, sys.stdout)
