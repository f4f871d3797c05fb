"""The free run beside general solvers: same model, same accuracy, one run, one thread.

Accuracy that each has to meet: every node's temperature within `TEMPERATURE_ERROR` of that node's
rise at every instant, and the peak of each pressure in every second within `PEAK_ERROR` of the
largest. Each is held against its own converged reference, since the kernel's dry friction is
set-valued and that of the solvers is regularised (`continuous.FRICTION_WIDTH`).
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ddh_twin_py.benchmarks.continuous import SCALE, Problem
from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.benchmarks.solvers import Runner, casadi_cvodes, compare_symbolic, numbalsoda_lsoda, scipy_lsoda
from ddh_twin_py.benchmarks.tools import NotThere
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.cylinder import holding_pressure, rod_travel
from ddh_twin_py.physics.free_run import COMMAND_PARTS, HYDRAULIC_STEP, SAMPLED, free_run, free_run_sampled, settle
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.duty import Duty, DutyCommand
from ddh_twin_py.twin.intervals import INTERVAL

TEMPERATURE_ERROR = 1.0e-4
"""Of each node's rise."""
PEAK_ERROR = 0.01
"""Of the largest pressure."""
TOLERANCES = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7)
REFERENCE_TOLERANCE = 1e-9
CHOICES = ((1, 2.5e-3), (1, 2.0e-3), (1.25, 2.67e-3), (1.25, 2.0e-3), (1.25, 1.6e-3), (1, 1.0e-3), (2, 2.5e-3), (2, 1.67e-3),
           (2, 1.0e-3), (4, 1.0e-3), (4, 5.0e-4))
"""Parts of `INTERVAL` at which the network moves, and hydraulic steps in s: the kernel's choices, fastest first."""
REFERENCE_REFINEMENT = 10
"""By how much intervals are shorter for the kernel's reference; its steps are this times four shorter."""
GRID = 0.2
"""s between the instants at which temperatures are compared; every choice has the end of an interval there."""
PERIOD = INTERVAL / COMMAND_PARTS
_WANTED = {"numbalsoda": 5.0, "CasADi": 10.0, "scipy": 30.0}


class Cycle:
    """A duty as an open-loop command for the sheet's rig, and runs of the kernel over it.

    Args:
        rig: sheet. duty: what to do. duration: s, a whole number of intervals.
    """

    def __init__(self, rig: Rig, duty: Duty, duration: float) -> None:
        self.params = rig.declaring(duty.payload).parameters
        self.start = float(duty.ambient[0])
        self._position = duty.start_position
        record = self.params[0]
        self._pressure = holding_pressure(duty.start_position, 0.0, record)
        rod_speed_per_rad = rod_travel(record)
        program, state, nodes = DutyCommand(duty), self.state(), np.full(N, self.start)
        points, temperatures = np.zeros(1, OPERATING_DTYPE), np.empty((1, N))
        command = [0.0]
        for _ in range(round(duration / PERIOD)):
            command.append(program.step(state[HYDRAULIC_STATES.index("rod_position")], rod_speed_per_rad, PERIOD))
            edges = command[-2] + np.arange(COMMAND_PARTS + 1) / COMMAND_PARTS * (command[-1] - command[-2])
            free_run(self.params, state, nodes, edges, np.full(1, self.start), PERIOD, 2.5e-4, np.full(1, np.nan), points, temperatures)
        self.command = np.array(command)
        self.duration = duration

    def state(self) -> np.ndarray:
        """Hydraulic state at rest at the start."""
        state = np.zeros(len(HYDRAULIC_STATES))
        settle(self.params, state, self._position, self._pressure, 0.0)
        return state

    def run(self, step: float, refinement: float = 1) -> tuple[np.ndarray, np.ndarray]:
        """Pressures at the command's edges, Pa, (n, 2), and temperature rises on the grid, K, (k, N)."""
        intervals = round(self.duration / INTERVAL * refinement)
        edges = np.interp(np.arange(intervals * COMMAND_PARTS + 1) / refinement, np.arange(self.command.size), self.command)
        nodes, points, temperatures = np.full(N, self.start), np.zeros(intervals, OPERATING_DTYPE), np.empty((intervals, N))
        instants = np.arange(1, self.command.size - 1) * PERIOD
        every = round(GRID / INTERVAL * refinement)
        samples = np.empty((instants.size, len(SAMPLED)))
        free_run_sampled(self.params, self.state(), nodes, edges, np.full(intervals, self.start), INTERVAL / refinement, step,
                         np.full(intervals, np.nan), points, temperatures, instants, samples)
        return samples[:, 2:4], temperatures[every - 1::every] - self.start

    def seconds(self, step: float, refinement: float = 1, threads: int = 1, repeats: int = 7) -> float:
        """Shortest wall time of a run in each of some threads, s."""
        intervals = round(self.duration / INTERVAL * refinement)
        edges = np.interp(np.arange(intervals * COMMAND_PARTS + 1) / refinement, np.arange(self.command.size), self.command)
        ambient, nowhere = np.full(intervals, self.start), np.full(intervals, np.nan)
        kept = [(np.zeros(intervals, OPERATING_DTYPE), np.empty((intervals, N))) for _ in range(threads)]

        def one(index: int) -> None:
            free_run(self.params, self.state(), np.full(N, self.start), edges, ambient, INTERVAL / refinement, step, nowhere,
                     *kept[index])

        best = float("inf")
        with ThreadPoolExecutor(threads) as pool:
            for _ in range(repeats):
                started = time.perf_counter()
                list(pool.map(one, range(threads)))
                best = min(best, time.perf_counter() - started)
        return best

    def problem(self) -> Problem:
        """The same run for general solvers."""
        return Problem(self.params, self.command, PERIOD, self.start, self.state())


def errors(pressures: np.ndarray, rises: np.ndarray, reference: tuple[np.ndarray, np.ndarray]) -> tuple[float, float]:
    """Largest temperature error over each node's rise, and of the pressures' peaks, second by second, over the largest."""
    true_pressures, true_rises = reference
    rise = np.abs(true_rises).max(axis=0)
    warm = rise > 1e-3 * rise.max()  # a node that nothing heats has no rise
    temperature = np.max(np.abs(rises - true_rises).max(axis=0)[warm] / rise[warm])
    each = round(1.0 / PERIOD)
    whole = pressures.shape[0] // each * each
    peaks = [part[:whole].reshape(-1, each, 2).max(axis=1) for part in (pressures, true_pressures)]
    return float(temperature), float(np.max(np.abs(peaks[0] - peaks[1]) / true_pressures.max(axis=0)))


def seen(states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What `errors` looks at, of a solver's states at the problem's times."""
    return states[1:-1, :2] * np.array(SCALE[:2]), states[round(GRID / PERIOD)::round(GRID / PERIOD), 5:]


def meets(error: tuple[float, float]) -> bool:
    """Whether errors are within both limits."""
    return error[0] <= TEMPERATURE_ERROR and error[1] <= PEAK_ERROR


def loosest(run: Runner, reference: tuple[np.ndarray, np.ndarray]) -> tuple[float, float]:
    """The loosest tolerance that is good enough, and the shortest of three times at it, s.

    Raises:
        NotThere: none is.
    """
    for tolerance in TOLERANCES:
        try:
            states, elapsed = run(tolerance)
        except NotThere:
            continue
        if meets(errors(*seen(states), reference)):
            return tolerance, min(elapsed, *(run(tolerance)[1] for _ in range(2)))
    raise NotThere("no tolerance was good enough")


def compare_solvers(rig: Rig, duty: Duty, duration: float) -> tuple[list[Figure], list[str]]:
    """Figures of the free run beside the tools, and the tools that were left out, with the reason."""
    cycle = Cycle(rig, duty, duration)
    reference = cycle.run(HYDRAULIC_STEP / (4 * REFERENCE_REFINEMENT), REFERENCE_REFINEMENT)
    default = errors(*cycle.run(HYDRAULIC_STEP), reference)
    by_step = errors(*cycle.run(HYDRAULIC_STEP), cycle.run(HYDRAULIC_STEP / (4 * REFERENCE_REFINEMENT)))
    refinement, step = next((choice for choice in CHOICES if meets(errors(*cycle.run(choice[1], choice[0]), reference))), CHOICES[-1])
    alone = duration / cycle.seconds(HYDRAULIC_STEP)
    own = duration / cycle.seconds(step, refinement)
    both = 2.0 * duration / cycle.seconds(HYDRAULIC_STEP, threads=2)
    figures = [
        Figure("free run as used, temperature error over rise", default[0], "", TEMPERATURE_ERROR, "limit"),
        Figure("of it by the hydraulic step", by_step[0], "", TEMPERATURE_ERROR, "limit"),
        Figure("free run as used, error of pressure peaks", default[1], "", PEAK_ERROR, "limit"),
        Figure(f"free run as used ({INTERVAL * 1e3:g} ms, {HYDRAULIC_STEP * 1e3:g} ms)", alone, "x real time", 1e4, "aim", smaller=False),
        Figure("free run as used, two at a time", both, "x real time", alone, "one at a time", smaller=False),
        Figure(f"free run, good enough ({INTERVAL / refinement * 1e3:g} ms, {step * 1e3:g} ms)", own, "x real time", 1e4, "aim",
               smaller=False),
    ]

    problem = cycle.problem()
    left_out = []
    try:
        figures.append(Figure("symbolic from compiled equations", compare_symbolic(problem, 200, seed=1), "", 1e-9, "limit"))
    except NotThere as reason:
        left_out.append(f"CasADi: {reason}")
    converged = None
    for name, make in (("numbalsoda", numbalsoda_lsoda), ("scipy", scipy_lsoda), ("CasADi", casadi_cvodes)):
        try:
            run = make(problem)
            if converged is None:
                converged = seen(run(REFERENCE_TOLERANCE)[0])
            tolerance, elapsed = loosest(run, converged)
        except NotThere as reason:
            left_out.append(f"{name}: {reason}")
            continue
        figures.append(Figure(f"the same beside {name} ({tolerance:g})", own, "x real time", duration / elapsed,
                              f"{name} here; wanted {_WANTED[name]:g} x", smaller=False))
    if converged is not None:
        figures.append(Figure("set-valued from regularised friction, temperature", errors(*reference, converged)[0], "of rise", None))
    return figures, list(dict.fromkeys(left_out))
