"""Writes physics/network_elimination.py from the tables of the thermal network. Run it after a change of them."""

from pathlib import Path

from ddh_twin_py.physics.thermal_network import EDGES, FLOWS, N, NODES

FILE = Path(__file__).resolve().parent.parent / "ddh_twin_py" / "ddh_twin_py" / "physics" / "network_elimination.py"
HEAD = '''"""Elimination of the thermal network, written out: scripts/network_elimination.py makes this file, nobody edits it.

Every step of a run factorises one matrix of one pattern; without loops over index tables that takes a third of the time.
"""

from __future__ import annotations

from ddh_twin_py.physics.compiled import kernel
'''


def later_nodes() -> list[list[int]]:
    """For each node the later nodes that it is tied to, fill-in included."""
    tied = {frozenset((row[-2], row[-1])) for row in (*EDGES, *FLOWS)}
    later = []
    for k in range(N):
        later.append([i for i in range(k + 1, N) if frozenset((i, k)) in tied])
        tied |= {frozenset((i, j)) for i in later[k] for j in later[k] if i != j}
    return later


def _factorise(later: list[list[int]]) -> list[str]:
    entries = [(k, k) for k in range(N)] + [place for k in range(N) for i in later[k] for place in ((i, k), (k, i))]
    lines = [f"    m_{i}_{j} = matrix[{i}, {j}]" for i, j in entries]
    for k in range(N):
        lines += [f"    # {NODES[k]}", f"    m_{k}_{k} = 1.0 / m_{k}_{k}"]
        for i in later[k]:
            lines.append(f"    m_{i}_{k} *= m_{k}_{k}")
            lines += [f"    m_{i}_{j} -= m_{i}_{k} * m_{k}_{j}" for j in later[k]]
    return lines + [f"    matrix[{i}, {j}] = m_{i}_{j}" for i, j in entries]


def _solve(later: list[list[int]]) -> list[str]:
    lines = [f"    x_{k} = x[{k}]" for k in range(N)]
    lines += [f"    x_{i} -= lu[{i}, {k}] * x_{k}" for k in range(N) for i in later[k]]
    for k in reversed(range(N)):
        lines += [f"    x_{k} -= lu[{k}, {j}] * x_{j}" for j in later[k]] + [f"    x_{k} *= lu[{k}, {k}]"]
    return lines + [f"    x[{k}] = x_{k}" for k in range(N)]


def source() -> str:
    """What the file holds."""
    later = later_nodes()
    return "\n".join([
        HEAD, "",
        "@kernel", "def factorise(matrix):",
        '    """LU of a matrix with the network\'s pattern (N, N), in place, without pivoting (it is diagonally dominant).', "",
        "    The diagonal holds the inverse pivots.", '    """', *_factorise(later), "", "",
        "@kernel", "def solve(lu, x):", '    """Solve lu x = x in place, x (N,); lu from `factorise`."""', *_solve(later), "",
    ])  # fmt: skip


if __name__ == "__main__":
    FILE.write_text(source(), encoding="utf-8")
    print(FILE)
