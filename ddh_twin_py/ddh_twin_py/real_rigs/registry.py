"""Rigs that can be studied, by the names of their packages."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

RIGS: tuple[str, ...] = ("emps", "cascaded_tanks", "eha", "zema")
"""Packages of this room; each has a ``study`` module with ``run(data, progress)`` and ``present(data)``."""


def study_of(rig: str) -> ModuleType:
    """The module that studies a rig: ``run(data: Path, progress) -> Study``, ``present(data: Path) -> bool``."""
    return import_module(f"ddh_twin_py.real_rigs.{rig}.study")
