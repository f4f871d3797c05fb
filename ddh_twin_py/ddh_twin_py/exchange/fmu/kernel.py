"""The free run as object code for this computer's kind of processor, without Python: numba's own LLVM does it."""

from __future__ import annotations

import re

from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.free_run import COMMAND_PARTS, free_run, settle
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig.sheet import PARAMETER_DTYPE

STEP, SETTLE = "ddh_step", "ddh_settle"
"""Names of the two functions in C, see `fmi2_slave.c` for their arguments."""


def object_code() -> dict[str, bytes]:
    """Relocatable object files by function, for any x86-64 (or any processor of the kind that this is), position independent.

    Raises ExchangeError where the compiler refuses.
    """
    import llvmlite.binding as llvm
    import numba
    from numba import carray, types

    record, point = numba.from_dtype(PARAMETER_DTYPE), numba.from_dtype(OPERATING_DTYPE)
    real, pointer = types.float64, types.CPointer(types.float64)
    states, edges = len(HYDRAULIC_STATES), COMMAND_PARTS + 1

    def step(params, state, temperature, command, ambient, interval, wanted, position, points, temperatures):
        return free_run(
            carray(params, (1,)), carray(state, (states,)), carray(temperature, (N,)), carray(command, (edges,)),
            carray(ambient, (1,)), interval, wanted, carray(position, (1,)), carray(points, (1,)), carray(temperatures, (1, N)),
        )

    def rest(params, state, position, pressure_a, pressure_b):
        settle(carray(params, (1,)), carray(state, (states,)), position, pressure_a, pressure_b)

    signatures = {
        STEP: (step, real(types.CPointer(record), pointer, pointer, pointer, pointer, real, real, pointer, types.CPointer(point), pointer)),
        SETTLE: (rest, types.void(types.CPointer(record), pointer, real, real, real)),
    }
    found = {}
    for name, (function, signature) in signatures.items():
        compiled = numba.cfunc(signature)(function)
        own = re.escape(compiled.native_name)
        text = re.sub(rf'@(?:"{own}"|{own}(?![\w.$]))', f"@{name}", compiled.inspect_llvm())
        try:
            module = llvm.parse_assembly(text)
            target = llvm.Target.from_triple(llvm.get_process_triple())
            machine = target.create_target_machine(cpu="", features="", opt=2, reloc="pic")
            found[name] = machine.emit_object(module)
        except RuntimeError as error:
            raise ExchangeError(f"the model cannot be compiled for an FMU: {' '.join(str(error).split())}") from None
    return found
