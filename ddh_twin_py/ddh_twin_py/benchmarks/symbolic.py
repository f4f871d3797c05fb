"""The right-hand side as a CasADi expression, traced from the very functions that are compiled.

The Python functions beneath the compiled ones are run on symbols, with `math`, `max`, `min` and
`abs` replaced by CasADi's. Functions that branch on a state have a replacement of one line here.
"""

from __future__ import annotations

import math
from types import FunctionType, ModuleType, SimpleNamespace

import numpy as np
from numba.core.registry import CPUDispatcher

from ddh_twin_py.benchmarks import continuous
from ddh_twin_py.benchmarks.continuous import N, N_EDGES, N_SURFACES, N_WALLS, STATES, Problem
from ddh_twin_py.physics import pump
from ddh_twin_py.physics.balance import OPERATING_DTYPE


class _Tracer:
    """Copies of compiled functions that take symbols."""

    def __init__(self, casadi: ModuleType) -> None:
        self._copies: dict[int, FunctionType] = {}
        self._mathematics = SimpleNamespace(
            pi=math.pi, log=casadi.log, exp=casadi.exp, sqrt=casadi.sqrt, tanh=casadi.tanh,
            copysign=lambda size, sign: casadi.if_else(sign < 0.0, -abs(size), abs(size)),
        )
        self._builtins = {"max": casadi.fmax, "min": casadi.fmin, "abs": casadi.fabs, "range": range, "__import__": __import__}
        self._instead = {
            "where": casadi.if_else,
            "smooth_sign": lambda speed: casadi.tanh(speed / pump.SIGN_WIDTH),
            "coulomb_friction": lambda velocity, difference, p: (
                (p.cylinder_friction_coulomb + p.cylinder_friction_pressure * casadi.fabs(difference))
                * (1.0 + (p.cylinder_stribeck_ratio - 1.0) * casadi.exp(-((velocity / p.cylinder_stribeck_velocity) ** 2)))
            ),
            "_friction_force": lambda velocity, dry, drive, p: 0.0,  # looked at, in no equation
            "iron_losses": lambda speed, iron, p: self._iron_losses(casadi, speed, iron, p),
        }

    @staticmethod
    def _iron_losses(casadi, speed, iron, p):
        frequency = p.motor_pole_pairs * casadi.fabs(speed) / (2.0 * math.pi)
        power, square = frequency ** p.motor_iron_alpha, frequency * frequency
        excess = frequency ** p.motor_iron_excess_exponent
        return iron[0] * power + iron[2] * square + iron[4] * excess, iron[1] * power + iron[3] * square + iron[5] * excess

    def of(self, function):
        """The copy of one function, its callees copied too."""
        name = function.py_func.__name__
        if name in self._instead:
            return self._instead[name]
        if id(function) not in self._copies:
            names = dict(function.py_func.__globals__) | {"__builtins__": self._builtins}  # bound when the copy is made
            copy = FunctionType(function.py_func.__code__, names, name)
            self._copies[id(function)] = copy
            for key in function.py_func.__code__.co_names:
                value = names.get(key)
                if isinstance(value, CPUDispatcher):
                    names[key] = self.of(value)
                elif value is math:
                    names[key] = self._mathematics
                elif isinstance(value, ModuleType) and value.__name__.startswith("ddh_twin_py.physics."):
                    names[key] = _Module(value, self)
        return self._copies[id(function)]


class _Module:
    """A module of the physics whose functions take symbols."""

    def __init__(self, module: ModuleType, tracer: _Tracer) -> None:
        self._module, self._tracer = module, tracer

    def __getattr__(self, name: str):
        value = getattr(self._module, name)
        return self._tracer.of(value) if isinstance(value, CPUDispatcher) else value


class _Zeros(list):
    """Numbers that take the kernels' ``heat[:] = 0``."""

    def __setitem__(self, key, value):
        super().__setitem__(key, [value] * len(self) if isinstance(key, slice) else value)


def symbolic_rates(casadi: ModuleType, y, command, slope, problem: Problem):
    """dy/dt as an expression of y (STATES), command (rad/s) and its slope (rad/s2), with the problem's parameters."""
    record = problem.params[0]
    p = SimpleNamespace(**{name: float(record[name]) for name in record.dtype.names})
    point = SimpleNamespace(**dict.fromkeys(OPERATING_DTYPE.names, 0.0))
    point.heat, point.flow = _Zeros([0.0] * N), _Zeros([0.0] * OPERATING_DTYPE["flow"].shape[0])
    second, third = N_EDGES + N_WALLS, N_EDGES + N_WALLS + 3 * N_SURFACES
    edge, wall = problem.work[:N_EDGES].tolist(), problem.work[N_EDGES:second].tolist()
    surface = problem.work[second:third].reshape(N_SURFACES, 3)
    out = [0.0] * STATES
    states = [y[i] for i in range(STATES)]
    _Tracer(casadi).of(continuous.derivatives)(
        states, problem.start, command, slope, problem.start, [p], point, edge, wall, _Rows(surface), [0.0] * N, [0.0] * N, [0.0] * N, out,
    )
    return casadi.vertcat(*out)


class _Rows:
    """A matrix of plain numbers, so that CasADi and not numpy does the sums."""

    def __init__(self, values: np.ndarray) -> None:
        self._values = values

    def __getitem__(self, key) -> float:
        return float(self._values[key])
