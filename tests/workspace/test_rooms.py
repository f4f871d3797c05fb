"""Imports go down the table of docs/architecture.md, and rclpy stays in the nodes."""

import ast
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = "ddh_twin_py"


def rooms_of_architecture(text: str) -> list[set[str]]:
    """The table's rooms, lowest first; a row may hold more than one."""
    rows = []
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if line.startswith("|") and re.fullmatch(r"`\w+`(, `\w+`)*", cells[0]):
            rows.append(set(re.findall(r"\w+", cells[0])))
    return rows


def imports_of(path: Path, module: tuple[str, ...]) -> list[tuple[int, tuple[str, ...]]]:
    """Line and dotted name of everything that a module imports, also inside functions."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), str(path))):
        if isinstance(node, ast.Import):
            found += [(node.lineno, tuple(alias.name.split("."))) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = module[: len(module) - node.level] if node.level else ()
            name = (*base, *(node.module.split(".") if node.module else ()))
            found += [(node.lineno, (*name, alias.name)) for alias in node.names]
        elif (
            isinstance(node, ast.Call)
            and ast.unparse(node.func).split(".")[-1] in {"import_module", "__import__"}
            and node.args
            and isinstance(node.args[0], ast.Constant)
            and isinstance(node.args[0].value, str)
        ):
            found.append((node.lineno, tuple(node.args[0].value.split("."))))
    return found


def violations(package: Path, rooms: list[set[str]]) -> list[str]:
    height = {room: level for level, row in enumerate(rooms) for room in row}
    wrong = []
    for path in sorted(package.rglob("*.py")):
        inside = path.relative_to(package).with_suffix("").parts
        # A package's own __init__ resolves "." to itself, a module to its parent.
        module = (package.name, *inside)
        room = inside[0] if len(inside) > 1 else None
        where = "/".join((package.name, *inside)) + ".py"
        if room is not None and room not in height:
            wrong.append(f"{where}: room {room!r} is not in the table of docs/architecture.md")
            continue
        for line, name in imports_of(path, module):
            if name[0] in {"rclpy", "launch_ros"} and room != "nodes":
                wrong.append(f"{where}:{line}: imports {name[0]} outside nodes")
            if name[0] != package.name or len(name) < 2:
                continue
            other = name[1]
            if room is None:
                if other in height:
                    wrong.append(f"{where}:{line}: the package itself imports room {other}")
            elif other in height and other != room and height[other] >= height[room]:
                wrong.append(f"{where}:{line}: {room} imports {other}, which is not below it")
    return list(dict.fromkeys(wrong))


def folders_of_architecture(text: str) -> dict[str, list[str]]:
    """The folders of every room that has a table of its own, lowest first."""
    rooms: dict[str, list[str]] = {}
    for room, folder in re.findall(r"^\| `(\w+)/(\w+)` \|", text, re.MULTILINE):
        rooms.setdefault(room, []).append(folder)
    return rooms


def modules_of(package: Path) -> dict[tuple[str, ...], Path]:
    """Dotted name to file, of every module of a package; a folder's is that of its ``__init__``."""
    named = {path: (package.name, *path.relative_to(package).with_suffix("").parts) for path in package.rglob("*.py")}
    return {name[:-1] if name[-1] == "__init__" else name: path for path, name in named.items()}


def ties_of(package: Path) -> dict[tuple[str, ...], set[tuple[str, ...]]]:
    """Every module to those of the package that it imports."""
    modules = modules_of(package)
    ties = {}
    for name, path in modules.items():
        inside = (*name, "__init__") if path.name == "__init__.py" else name
        taken = {other if other in modules else other[:-1] for _, other in imports_of(path, inside)}
        ties[name] = {other for other in taken if other in modules and other != name}
    return ties


def circle_of(ties: dict) -> tuple:
    """Modules of which each imports the next and the last one the first, () where there are none."""
    try:
        tuple(TopologicalSorter(ties).static_order())
    except CycleError as error:
        return tuple(error.args[1])
    return ()


@pytest.fixture(scope="module")
def rooms(repo_root):
    return rooms_of_architecture((repo_root / "docs/architecture.md").read_text())


def test_table_is_read(rooms):
    assert rooms[0] == {"rig"}
    assert rooms[-2:] == [{"nodes"}, {"cli"}]
    assert len(rooms) >= 8


def test_project_keeps_to_the_order(rooms, repo_root):
    wrong = violations(repo_root / PACKAGE / PACKAGE, rooms)
    assert not wrong, "\n".join(wrong)


def test_no_modules_import_each_other_in_a_circle(repo_root):
    assert circle_of(ties_of(repo_root / PACKAGE / PACKAGE)) == ()


def test_a_circle_is_found(tmp_path):
    package = tmp_path / PACKAGE
    package.mkdir()
    (package / "a.py").write_text(f"from {PACKAGE} import b")
    (package / "b.py").write_text(f"def late():\n    from {PACKAGE}.c import x")
    (package / "c.py").write_text(f"import {PACKAGE}.a")
    assert {name[-1] for name in circle_of(ties_of(package))} == {"a", "b", "c"}


def test_folders_of_a_room_keep_to_their_order(repo_root):
    package = repo_root / PACKAGE / PACKAGE
    rooms = folders_of_architecture((repo_root / "docs/architecture.md").read_text())
    wrong = []
    for room, folders in rooms.items():
        assert set(folders) == {path.name for path in (package / room).iterdir() if (path / "__init__.py").is_file()}
        height = {(PACKAGE, room, folder): level for level, folder in enumerate(folders)}
        wrong += [f"{'.'.join(name)} imports {'.'.join(other)}" for name, others in ties_of(package).items() for other in others
                  if height.get(other[:3], -1) > height.get(name[:3], len(folders))]
    assert "gap" in rooms and not wrong, "\n".join(wrong)


def test_every_room_is_a_package(rooms, repo_root):
    """A folder without __init__.py is left out when the package is installed."""
    package = repo_root / PACKAGE / PACKAGE
    folders = {path.parent for path in package.rglob("*.py")}
    assert not [str(f) for f in folders if not (f / "__init__.py").is_file()]


@pytest.mark.parametrize(
    ("file", "code", "complaint"),
    [
        ("rig/sheet.py", "from ddh_twin_py.physics import oil", "rig imports physics"),
        ("rig/sheet.py", "from ..physics import oil", "rig imports physics"),
        ("rig/sheet.py", "from .. import physics", "rig imports physics"),
        ("rig/__init__.py", "from ..physics import oil", "rig imports physics"),
        ("physics/oil.py", "def late():\n    import ddh_twin_py.twin.duty", "physics imports twin"),
        ("twin/run.py", "import importlib\nimportlib.import_module('ddh_twin_py.nodes.x')", "twin imports nodes"),
        ("nodes/bag_player.py", "from ddh_twin_py import cli", "nodes imports cli"),
        ("cli/main.py", "import rclpy.node", "imports rclpy outside nodes"),
        ("__init__.py", "from rclpy import init", "imports rclpy outside nodes"),
        ("attic/old.py", "", "room 'attic' is not in the table"),
    ],
)
def test_a_breach_is_found(tmp_path, rooms, file, code, complaint):
    path = tmp_path / PACKAGE / file
    path.parent.mkdir(parents=True)
    path.write_text(code)
    (wrong,) = violations(tmp_path / PACKAGE, rooms)
    assert complaint in wrong


@pytest.mark.parametrize(
    ("file", "code"),
    [
        ("physics/oil.py", "import numpy\nfrom ddh_twin_py.rig import sheet\nfrom . import pump"),
        ("physics/__init__.py", "from .oil import Oil\nfrom ..rig import sheet"),
        ("nodes/fusion.py", "import rclpy\nfrom ..estimation.replay import run"),
    ],
)
def test_what_is_allowed_is_allowed(tmp_path, rooms, file, code):
    path = tmp_path / PACKAGE / file
    path.parent.mkdir(parents=True)
    path.write_text(code)
    assert violations(tmp_path / PACKAGE, rooms) == []
