"""Finds the sources: every file of this folder that has a `NAME`."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

from ddh_twin_py import sources
from ddh_twin_py.names import no_such
from ddh_twin_py.sources.protocol import Source, SourceError


def source_modules() -> dict[str, ModuleType]:
    """Modules of all sources by name."""
    found = {}
    for info in iter_modules(sources.__path__):
        module = import_module(f"{sources.__name__}.{info.name}")
        if hasattr(module, "NAME") and hasattr(module, "open_source"):
            found[module.NAME] = module
    return dict(sorted(found.items()))


def open_source(name: str, options: Mapping[str, object]) -> Source:
    """Open a source. Raises SourceError naming the nearest valid name where there is none of that name."""
    modules = source_modules()
    if name not in modules:
        raise SourceError(no_such("source", name, modules))
    return modules[name].open_source(options)
