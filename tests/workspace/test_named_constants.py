"""Constants that documents name are in the files that they name."""

import importlib
import pkgutil
import re

import ddh_twin_py

MODULES = [found.name for found in pkgutil.walk_packages(ddh_twin_py.__path__, "ddh_twin_py.")]
NAMED = re.compile(r"(?:([a-z][a-z_0-9.]*)\.)?(_?[A-Z][A-Z_0-9]+)")


def named(page: str) -> list[tuple[str, str]]:
    """Ends of modules and constants, of a page; a constant beside another in the same cell is of its file."""
    out = []
    for line in page.splitlines():
        for cell in line.split("|"):
            module = ""
            for span in re.findall(r"`([^`]+)`", cell):
                found = NAMED.fullmatch(span)
                module = found[1] or module if found else module
                if found and module and module != "module":
                    out.append((module, found[2]))
    return out


def missing(page: str) -> list[str]:
    """Those that no file has, or more than one."""
    out = []
    for module, constant in named(page):
        files = [name for name in MODULES if f".{name}".endswith(f".{module}")]
        if sum(hasattr(importlib.import_module(name), constant) for name in files) != 1:
            out.append(f"{module}.{constant}")
    return out


def test_every_constant_of_the_method_is_where_its_page_says(repo_root):
    page = (repo_root / "docs" / "gap_method.md").read_text()
    assert missing(page) == [] and len(named(page)) >= 200


def test_a_constant_that_moved_is_seen():
    assert missing("| `fitting.RESTARTS`, `_FAR` | 2 |") == ["fitting.RESTARTS", "fitting._FAR"]
    assert missing("| `problem.RESTARTS`, `_FAR` | 2 |") == []
