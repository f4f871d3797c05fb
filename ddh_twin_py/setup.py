"""The ament_python package of the twin: modules, executables, launch and parameter files."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = "ddh_twin_py"
NODES = (
    "drive_telemetry",
    "pressure_telemetry",
    "hydraulic_model",
    "machine_thermal",
    "temperature_fusion",
    "gap_monitor",
    "bag_player",
    "bag_recorder",
    "web_view",
)


def not_python(package: str) -> list[str]:
    """Everything in the package that is no module: data sheets, report templates, scripts."""
    root = Path(package)
    return sorted(
        str(path.relative_to(root))
        for path in root.rglob("*")
        if path.is_file()
        and path.suffix not in {".py", ".pyc", ".nbi", ".nbc"}
        and "__pycache__" not in path.parts
    )


def shared(folder: str, *patterns: str) -> list[tuple[str, list[str]]]:
    """Files of a folder and of those in it, each installed to the same place below share."""
    files = {path for pattern in patterns for path in Path(folder).rglob(pattern)}
    return [
        (f"share/{NAME}/{parent}", sorted(str(path) for path in files if path.parent == parent))
        for parent in sorted({path.parent for path in files})
    ]


setup(
    name=NAME,
    version="0.1.0",
    description="Digital twin of a direct driven hydraulic unit.",
    license="Apache-2.0",
    maintainer="DDH twin maintainers",
    maintainer_email="maintainers@ddh-twin.example",
    python_requires=">=3.11",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: not_python(NAME)},
    zip_safe=False,
    install_requires=["setuptools"],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *shared("launch", "*.launch.py"),
        *shared("config", "*.yaml", "*.xml", "*.json"),
    ],
    entry_points={
        "console_scripts": [
            "ddh-twin = ddh_twin_py.cli.main:main",
            *(f"{node} = ddh_twin_py.nodes.{node}:main" for node in NODES),
        ],
    },
)
