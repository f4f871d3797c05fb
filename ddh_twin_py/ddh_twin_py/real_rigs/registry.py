"""Rigs that can be studied, by the names of their packages."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

RIGS: tuple[str, ...] = ("emps", "cascaded_tanks", "eha", "zema")
"""Packages of this room, and folders of their recordings; each has a ``study`` module with ``run(data, progress)``."""


def study_of(rig: str) -> ModuleType:
    """The module that studies a rig: ``run(data: Path, progress) -> Study``."""
    return import_module(f"ddh_twin_py.real_rigs.{rig}.study")
