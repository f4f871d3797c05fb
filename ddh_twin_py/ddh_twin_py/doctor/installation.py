"""Is the twin installed as it must be: Python, packages, messages, compiled models, space."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterable
from importlib import metadata, util
from pathlib import Path

from ddh_twin_py.doctor.check import Check

GROUP = "installation"
PYTHONS = ((3, 11), (3, 12))
NEEDED = ("numpy", "scipy", "numba", "rosbags", "apsw", "lz4", "backports.zstd", "PyYAML", "rich", "aiohttp")
OF_SINGLE_VERBS = {"pyarrow": "export --parquet, fleet --parquet", "llvmlite": "fmu", "shtab": "completion"}
"""What needs a package that nothing else does, and that no package of ROS 2 brings along."""
_LEAST_SPACE = 1e9  # bytes
_MESSAGES = ("DriveTelemetry", "HydraulicTelemetry", "RigInfo", "TemperatureEstimateArray", "HydraulicState", "GapStatus")


def check_installation(folder: str | Path = ".") -> list[Check]:
    """Everything that can be looked at without starting ROS.

    Args:
        folder: where reports and recordings are going to be written.
    """
    return [_python(), _packages(), _ros(), _messages(), _cache(), _space(Path(folder))]


def _python() -> Check:
    version = sys.version_info[:2]
    right = " or ".join(f"{a}.{b}" for a, b in PYTHONS)
    found = f"{version[0]}.{version[1]} ({sys.executable})"
    if version in PYTHONS:
        return Check(GROUP, "Python", "ok", found, right)
    return Check(GROUP, "Python", "error", found, right, "run make setup with DDH_PYTHON=python3.12")


def _packages() -> Check:
    if missing := _missing(NEEDED):
        return Check(GROUP, "packages", "error", f"missing: {', '.join(missing)}", "all installed", "run make setup")
    if missing := _missing(OF_SINGLE_VERBS):
        without = f"needed by {'; '.join(f'{OF_SINGLE_VERBS[name]} ({name})' for name in missing)} alone: run make setup"
        return Check(GROUP, "packages", "note", f"missing: {', '.join(missing)}", "all installed", without)
    return Check(GROUP, "packages", "ok", f"{len(NEEDED) + len(OF_SINGLE_VERBS)} installed", "all installed")


def _missing(names: Iterable[str]) -> list[str]:
    """Those of some distributions that are not installed."""
    missing = []
    for name in names:
        try:
            metadata.version(name)
        except metadata.PackageNotFoundError:
            missing.append(name)
    return missing


def _ros() -> Check:
    distribution = os.environ.get("ROS_DISTRO", "")
    if util.find_spec("rclpy") is None:
        advice = "run .venv/bin/ddh-twin, or source the ROS 2 workspace; without ROS 2 recordings can be read all the same"
        return Check(GROUP, "ROS 2", "warning", "rclpy is not here", "Jazzy", advice)
    if distribution != "jazzy":
        advice = "the twin is built for Jazzy: run .venv/bin/ddh-twin, or source /opt/ros/jazzy/setup.bash"
        return Check(GROUP, "ROS 2", "warning", f"ROS_DISTRO is {distribution!r}", "jazzy", advice)
    return Check(GROUP, "ROS 2", "ok", "Jazzy", "Jazzy")


def _messages() -> Check:
    if util.find_spec("ddh_msgs") is None:
        return Check(GROUP, "ddh_msgs", "warning", "not here", "built", "run make setup, or build ros2_ws with colcon and source it")
    try:
        import ddh_msgs.msg
    except ImportError as error:
        return Check(GROUP, "ddh_msgs", "error", f"cannot be loaded: {error}", "built for this Python", "run make distclean and make setup")
    missing = [name for name in _MESSAGES if not hasattr(ddh_msgs.msg, name)]
    if missing:
        found = f"{Path(ddh_msgs.msg.__file__).parent}: no {', '.join(missing)}"
        return Check(GROUP, "ddh_msgs", "error", found, "the same version as ddh_twin_py", "build ddh_msgs anew: make setup")
    return Check(GROUP, "ddh_msgs", "ok", "built", "built")


def _cache() -> Check:
    """Compiled models are kept in a folder of the user; where that is not possible, every start takes as long as the first."""
    import numba

    import ddh_twin_py.physics.compiled  # noqa: F401 - says where they are kept

    advice = "set DDH_TWIN_CACHE to a folder that can be written; else each process compiles for half a minute"
    folder = numba.config.CACHE_DIR
    if not folder:
        return Check(GROUP, "compiled models", "warning", "kept nowhere", "kept in a folder", advice)
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        return Check(GROUP, "compiled models", "warning", f"{folder} cannot be written: {error.strerror}", "kept in a folder", advice)
    return Check(GROUP, "compiled models", "ok", f"kept in {folder}", "kept in a folder")


def _space(folder: Path) -> Check:
    free = shutil.disk_usage(folder).free
    found, right = f"{free / 1e9:.1f} GB free in {folder.resolve()}", "1 GB; an hour recorded takes about 0.05 GB"
    if free < _LEAST_SPACE:
        return Check(GROUP, "disk", "warning", found, right, "make room, or record elsewhere")
    return Check(GROUP, "disk", "ok", found, right)
