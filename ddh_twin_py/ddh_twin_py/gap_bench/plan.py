"""Which cases a bench has: a seeded list in which suites and effects are mixed and names say nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.plant.listed_faults import LISTED
from ddh_twin_py.plant.unlisted_faults import UNLISTED

LEVELS = ("clear", "moderate", "faint")
SUITES = ("none", "single", "two", "tolerance", "left_out", "outside")
"""No effect; one effect; two at once; parameters off within tolerance; the true effect taken from the catalogue; an effect that
is in no catalogue."""
_SHARES = {"none": 0.14, "single": 0.44, "two": 0.14, "tolerance": 0.08, "left_out": 0.08, "outside": 0.12}
_COMMISSIONED = {"none": 0.6, "single": 0.7, "two": 1.0, "tolerance": 0.0, "left_out": 1.0, "outside": 1.0}


class PlanError(ValueError):
    """A bench that cannot be planned or read; one line for people."""


@dataclass(frozen=True)
class Planned:
    """One case to be made.

    Attributes:
        name: of its folders. suite, level ('' where nothing is hidden): what it belongs to. effects: what is to be hidden,
            most wanted first; as many as the suite hides are taken, further ones where one is not possible.
        hidden: how many. commissioning: whether there is a recording of the rig as built. seed: of everything drawn.
    """

    name: str
    suite: str
    level: str
    effects: tuple[str, ...]
    hidden: int
    commissioning: bool
    seed: int


def plan(cases: int, seed: int, suites: tuple[str, ...] = SUITES) -> list[Planned]:
    """The cases of a bench.

    Args:
        cases: how many. seed: of the whole bench. suites: those to be used, in their usual proportions.

    Raises:
        PlanError: for no case, or a suite that does not exist.
    """
    for suite in suites:
        if suite not in SUITES:
            raise PlanError(f"suite is {suite!r}, allowed are {', '.join(SUITES)}")
    if cases < 1 or not suites:
        raise PlanError(f"a bench of {cases} cases in {len(suites)} suites, at least one of each is needed")
    rng = np.random.default_rng((seed, 0x6A9))
    shares = np.array([_SHARES[suite] for suite in suites])
    edges = np.rint(np.cumsum(shares / shares.sum()) * cases).astype(int)
    counts = np.diff(np.concatenate([[0], edges]))
    rows: list[tuple[str, str, tuple[str, ...], int, bool]] = []
    listed, unlisted = _endless(rng, sorted(LISTED)), _endless(rng, sorted(UNLISTED))
    for suite, count in zip(suites, counts, strict=True):
        levels = LEVELS if suite in ("single", "two") else LEVELS[:2] if suite in ("left_out", "outside") else ("",)
        first = int(rng.integers(len(levels)))
        commissioned = np.arange(count) < round(_COMMISSIONED[suite] * count)
        rng.shuffle(commissioned)
        for k in range(count):
            hidden = {"none": 0, "tolerance": 0, "two": 2}.get(suite, 1)
            effects: tuple[str, ...] = ()
            if hidden:
                wanted = [next(unlisted if suite == "outside" else listed) for _ in range(hidden)]
                pool = sorted(UNLISTED if suite == "outside" else LISTED)
                rng.shuffle(pool)
                effects = tuple(dict.fromkeys(wanted + pool))
            rows.append((suite, levels[(first + k) % len(levels)], effects, hidden, bool(commissioned[k])))
    order = rng.permutation(len(rows))
    seeds = rng.integers(0, 2**31, len(rows))
    return [Planned(f"case_{i + 1:04d}", *rows[k], int(seeds[i])) for i, k in enumerate(order)]


def _endless(rng: np.random.Generator, names: list[str]):
    """The names in random order, again and again, so that each comes about equally often."""
    while True:
        mixed = list(names)
        rng.shuffle(mixed)
        yield from mixed
