"""The continuous model in other tools: numbalsoda's LSODA, scipy's LSODA, CasADi's CVODES.

Each runner takes a `Problem` and a tolerance and gives the states at the problem's times and the
seconds that solving took, compilation and construction not counted.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numba
import numpy as np
from numba import types
from numba.extending import intrinsic

from ddh_twin_py.benchmarks.continuous import STATES, WORK, Problem, rates
from ddh_twin_py.benchmarks.symbolic import symbolic_rates
from ddh_twin_py.benchmarks.tools import NotThere, tool
from ddh_twin_py.physics.balance import OPERATING_DTYPE

Runner = Callable[[float], tuple[np.ndarray, float]]
"""Tolerance to states, (times, STATES), and seconds."""


def scipy_lsoda(problem: Problem) -> Runner:
    """`scipy.integrate.solve_ivp` with LSODA on the compiled right-hand side."""
    from scipy.integrate import solve_ivp

    problem.rates(0.0, problem.initial)

    def run(tolerance: float) -> tuple[np.ndarray, float]:
        started = time.perf_counter()
        solution = solve_ivp(problem.rates, (0.0, problem.times[-1]), problem.initial, method="LSODA", rtol=tolerance, atol=tolerance,
                             t_eval=problem.times)
        elapsed = time.perf_counter() - started
        if solution.status != 0 or solution.y.shape[1] != problem.times.size:
            raise NotThere(f"LSODA stopped: {solution.message}")
        return solution.y.T, elapsed

    return run


def numbalsoda_lsoda(problem: Problem) -> Runner:
    """LSODA of numbalsoda on the right-hand side as a C callback, without Python in between."""
    package = tool("numbalsoda")
    to_params, to_point = _pointer_to(numba.from_dtype(problem.params.dtype)), _pointer_to(numba.from_dtype(OPERATING_DTYPE))
    to_numbers, n_params = _pointer_to(types.float64), problem.params.size
    n_command = problem.command.size
    period, start = problem.period, problem.start
    addresses = np.array([problem.params.ctypes.data, problem.point.ctypes.data, problem.work.ctypes.data, problem.command.ctypes.data])
    data = addresses.astype(np.int64).view(np.float64)

    @numba.cfunc(types.void(types.double, types.CPointer(types.double), types.CPointer(types.double), types.CPointer(types.int64)),
                 error_model="numpy")
    def callback(t, y, out, where_all_is):
        at = numba.carray(where_all_is, 4)
        params = numba.carray(to_params(at[0]), n_params)
        point = numba.carray(to_point(at[1]), 1)
        work = numba.carray(to_numbers(at[2]), WORK)
        command = numba.carray(to_numbers(at[3]), n_command)
        rates(t, numba.carray(y, STATES), command, period, start, params, point, work, numba.carray(out, STATES))

    address = callback.address

    def run(tolerance: float) -> tuple[np.ndarray, float]:
        started = time.perf_counter()
        states, success = package.lsoda(address, problem.initial, problem.times, data=data, rtol=tolerance, atol=tolerance,
                                       mxstep=1_000_000)
        elapsed = time.perf_counter() - started
        if not success:
            raise NotThere("LSODA of numbalsoda stopped")
        return states, elapsed

    run.keep = callback  # the address is valid as long as this lives
    package.lsoda(address, problem.initial, problem.times[:2], data=data, rtol=1e-4, atol=1e-4)  # compiled here
    return run


def _pointer_to(kind):
    """A compiled function from an address to a pointer to values of a numba type."""

    @intrinsic
    def pointer(typingctx, address):
        def codegen(context, builder, signature, arguments):
            return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

        return types.CPointer(kind)(types.int64), codegen

    return pointer


def casadi_cvodes(problem: Problem) -> Runner:
    """CVODES of CasADi on the symbolic right-hand side, checked before against the compiled one."""
    casadi = tool("casadi")
    y, begin, slope, t = casadi.SX.sym("y", STATES), casadi.SX.sym("begin"), casadi.SX.sym("slope"), casadi.SX.sym("t")
    dae = {"x": y, "t": t, "p": casadi.vertcat(begin, slope), "ode": symbolic_rates(casadi, y, begin + slope * t, slope, problem)}
    slopes = np.diff(problem.command) / problem.period
    # Restarted where the command has a corner, which a multistep method cannot step over with its history.
    corners = [0, *(np.flatnonzero(np.abs(np.diff(slopes)) > 1e-6) + 1).tolist(), slopes.size]

    def run(tolerance: float) -> tuple[np.ndarray, float]:
        options = {"reltol": tolerance, "abstol": tolerance, "max_num_steps": 10_000_000}
        solvers = {
            length: casadi.integrator("run", "cvodes", dae, 0.0, (np.arange(1, length + 1) * problem.period).tolist(), options)
            for length in set(np.diff(corners).tolist())
        }
        states = np.empty((problem.times.size, STATES))
        states[0] = problem.initial
        started = time.perf_counter()
        for first, last in zip(corners[:-1], corners[1:], strict=True):
            try:
                solution = solvers[last - first](x0=states[first], p=[problem.command[first], slopes[first]])
            except RuntimeError as error:
                raise NotThere(f"CVODES of CasADi stopped: {str(error).strip().splitlines()[-1]}") from None
            states[first + 1:last + 1] = np.array(solution["xf"]).T
        return states, time.perf_counter() - started

    return run


def compare_symbolic(problem: Problem, count: int, seed: int) -> float:
    """Largest difference of the symbolic from the compiled right-hand side at random states.

    Each state's difference is counted against the largest of its rates over the states drawn.

    Raises:
        NotThere: CasADi is not.
    """
    casadi = tool("casadi")
    y, command, slope = casadi.SX.sym("y", STATES), casadi.SX.sym("command"), casadi.SX.sym("slope")
    function = casadi.Function("rates", [y, command, slope], [symbolic_rates(casadi, y, command, slope, problem)])
    rng = np.random.default_rng(seed)
    compiled, traced = np.empty((count, STATES)), np.empty((count, STATES))
    for i in range(count):
        mechanical = rng.uniform([-0.2, -0.2, -2.0, -0.01, -1.5], [15.0, 15.0, 2.0, 4.01, 1.5])
        state = np.concatenate([mechanical, rng.uniform(-20.0, 60.0, STATES - 5)])
        state[2:5] *= rng.choice([0.0, 1e-6, 1e-3, 1.0], 3) if i % 3 else 1.0
        t = rng.uniform(0.0, problem.times[-1])
        at = min(int(t / problem.period), problem.command.size - 2)
        rise = (problem.command[at + 1] - problem.command[at]) / problem.period
        compiled[i] = problem.rates(t, state)
        traced[i] = np.array(function(state, problem.command[at] + rise * (t - at * problem.period), rise)).ravel()
    largest = np.abs(compiled).max(axis=0)
    return float(np.max(np.abs(traced - compiled).max(axis=0) / np.where(largest > 0.0, largest, 1.0)))
