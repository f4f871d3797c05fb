"""The FMU itself: model description, compiled binary, the rig file, what it rests on; one zip."""

from __future__ import annotations

import hashlib
import io
import os
import platform
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from importlib import resources
from pathlib import Path
from xml.etree import ElementTree as xml

from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.exchange.fmu import variables as of
from ddh_twin_py.exchange.fmu.kernel import object_code
from ddh_twin_py.exchange.fmu.variables import NOW, Variable, variables
from ddh_twin_py.physics.balance import OPERATING_DTYPE, OPERATING_FIELDS
from ddh_twin_py.physics.free_run import COMMAND_PARTS
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES, PRESSURE_A, PRESSURE_B
from ddh_twin_py.physics.oil import VAPOUR_PRESSURE
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.files import write_whole
from ddh_twin_py.rig.sheet import FIELD_OF_PATH, PARAMETER_DTYPE
from ddh_twin_py.rig.writer import rig_text

IDENTIFIER = "ddh_twin"
_PLATFORMS = {("Linux", "x86_64"): "linux64"}
_DISPLAY = {"Pa": ("bar", 1e-5, 0.0), "K": ("degC", 1.0, -273.15), "rad/s": ("rpm", 30.0 / 3.141592653589793, 0.0), "m": ("mm", 1e3, 0.0),
            "m3/s": ("L/min", 6e4, 0.0)}
_DIMENSIONS = {
    "Pa": {"kg": 1, "m": -1, "s": -2}, "K": {"K": 1}, "rad/s": {"rad": 1, "s": -1}, "m": {"m": 1}, "m/s": {"m": 1, "s": -1},
    "m3/s": {"m": 3, "s": -1}, "kg": {"kg": 1}, "s": {"s": 1}, "W": {"kg": 1, "m": 2, "s": -3}, "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2}, "A": {"A": 1}, "A2": {"A": 2}, "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
}
ASSUMPTIONS = (
    "The model is the twin's free run: speed command, payload and ambient in, nothing measured.",
    "The payload acts along the rod; friction, leakage and losses are those of the rig file.",
    "At the start the unit is at rest at one temperature.",
)


def write_fmu(path: str | Path, rig: Rig, progress: Callable[[float], None] | None = None) -> Path:
    """Write the twin of a rig as an FMU for the kind of computer that this is.

    Raises:
        ExchangeError: no C compiler, another kind of computer, or what the compiler said.
    """
    kind = _PLATFORMS.get((platform.system(), platform.machine()))
    if kind is None:
        known = ", ".join(" ".join(pair) for pair in _PLATFORMS)
        raise ExchangeError(f"{path}: an FMU cannot be made on {platform.system()} {platform.machine()}; known are {known}")
    compiler = _compiler()
    several = variables(rig)
    guid = _guid(several)
    tell = progress or (lambda share: None)
    tell(0.1)
    objects = object_code()
    tell(0.8)
    binary = _link(compiler, objects, _header(several, guid))
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", model_description(rig, several, guid))
        archive.writestr(f"binaries/{kind}/{IDENTIFIER}.so", binary)
        heading = f"What this FMU is of: {rig.file}. Entries that are not here are the reference sheet's."
        archive.writestr("resources/rig.yaml", rig_text(rig, heading))
        archive.writestr("documentation/index.html", _documentation(rig, several).html())
    return write_whole(path, content.getvalue())


def model_description(rig: Rig, several: Sequence[Variable], guid: str) -> str:
    """`modelDescription.xml` of FMI 2.0."""
    root = xml.Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": f"DDH twin {rig.rig_id}", "guid": guid, "version": doc.version(), "license": "Apache-2.0",
        "description": "Digital twin of a direct driven hydraulic unit: free run from speed command, payload and ambient.",
        "generationTool": f"ddh-twin {doc.version()}", "variableNamingConvention": "structured",
        "generationDateAndTime": datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
    })
    xml.SubElement(root, "CoSimulation", {
        "modelIdentifier": IDENTIFIER, "canHandleVariableCommunicationStepSize": "true", "canInterpolateInputs": "true",
        "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true", "maxOutputDerivativeOrder": "0",
        "needsExecutionTool": "false", "canBeInstantiatedOnlyOncePerProcess": "false",
    })
    units = xml.SubElement(root, "UnitDefinitions")
    for unit in sorted({variable.unit for variable in several} - {""}):
        entry = xml.SubElement(units, "Unit", {"name": unit})
        if unit in _DIMENSIONS:
            xml.SubElement(entry, "BaseUnit", {name: str(power) for name, power in _DIMENSIONS[unit].items()})
        if unit in _DISPLAY:
            name, factor, offset = _DISPLAY[unit]
            xml.SubElement(entry, "DisplayUnit", {"name": name, "factor": repr(factor), "offset": repr(offset)})
    categories = xml.SubElement(root, "LogCategories")
    xml.SubElement(categories, "Category", {"name": "logStatusError"})
    xml.SubElement(root, "DefaultExperiment", {"startTime": "0", "stopTime": "60", "stepSize": "0.05"})
    listed = xml.SubElement(root, "ModelVariables")
    outputs = []
    for index, variable in enumerate(several, 1):
        xml.SubElement(xml.SubElement(listed, "ScalarVariable", _scalar(variable)), "Real", _real(variable))
        if variable.group in (of.OUTPUT, of.TEMPERATURE):
            outputs.append(index)
    structure = xml.SubElement(root, "ModelStructure")
    for element in ("Outputs", "InitialUnknowns"):
        part = xml.SubElement(structure, element)
        for index in outputs:
            xml.SubElement(part, "Unknown", {"index": str(index)})
    xml.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + xml.tostring(root, encoding="unicode") + "\n"


def _scalar(variable: Variable) -> dict[str, str]:
    kinds = {
        of.INPUT: {"causality": "input", "variability": "continuous"},
        of.SETTING: {"causality": "parameter", "variability": "fixed" if variable.name.startswith("start.") else "tunable",
                     "initial": "exact"},
        of.PARAMETER: {"causality": "parameter", "variability": "tunable", "initial": "exact"},
        of.OUTPUT: {"causality": "output", "variability": "continuous", "initial": "calculated"},
        of.TEMPERATURE: {"causality": "output", "variability": "continuous", "initial": "calculated"},
    }
    return {"name": variable.name, "valueReference": str(variable.reference), "description": variable.about, **kinds[variable.group]}


def _real(variable: Variable) -> dict[str, str]:
    given = {"unit": variable.unit} if variable.unit else {}
    difference = variable.unit == "K" and variable.group == of.PARAMETER  # temperatures of the sheet are in degC
    if variable.unit in _DISPLAY and not difference:
        given["displayUnit"] = _DISPLAY[variable.unit][0]
    numbers = {"min": variable.lowest, "max": variable.highest, "start": variable.start}
    return given | {name: repr(float(number)) for name, number in numbers.items() if number is not None}


def _header(several: Sequence[Variable], guid: str) -> str:
    """`ddh_model.h`: counts, starts and places."""
    starts = {group: [v.start for v in several if v.group == group] for group in (of.INPUT, of.SETTING)}
    parameters = [0.0] * len(PARAMETER_DTYPE.names)
    for variable in several:
        if variable.group == of.PARAMETER:
            parameters[variable.reference - of.PARAMETER] = variable.start
    now = ", ".join(f"{{{OPERATING_FIELDS.index(name)}, {HYDRAULIC_STATES.index(name)}}}" for name in NOW)
    defined = {
        "GUID": f'"{guid}"', "PARAMETERS": len(parameters), "STATES": len(HYDRAULIC_STATES), "NODES": N, "OUTPUTS": len(OPERATING_FIELDS),
        "POINT": OPERATING_DTYPE.itemsize // 8, "COMMAND_PARTS": COMMAND_PARTS,
        "PAYLOAD": PARAMETER_DTYPE.names.index("load_payload_mass"), "FIRST_SETTING": of.SETTING, "FIRST_PARAMETER": of.PARAMETER,
        "FIRST_OUTPUT": of.OUTPUT, "FIRST_TEMPERATURE": of.TEMPERATURE, "STATE_PRESSURE_A": PRESSURE_A, "STATE_PRESSURE_B": PRESSURE_B,
        "VAPOUR_PRESSURE": repr(float(VAPOUR_PRESSURE)), "NOW": f"{{{now}}}", "INPUT_STARTS": _list(starts[of.INPUT]),
        "SETTING_STARTS": _list(starts[of.SETTING]), "PARAMETER_STARTS": _list(parameters),
        "STROKE": PARAMETER_DTYPE.names.index(FIELD_OF_PATH["cylinder.stroke"]), "BOUNDS": _bounds(several),
    }
    return "".join(f"#define DDH_{name} {value}\n" for name, value in defined.items())


def _list(numbers: Sequence[float]) -> str:
    return "{" + ", ".join(repr(float(number)) for number in numbers) + "}"


def _bounds(several: Sequence[Variable]) -> str:
    rows = [f'{{{v.reference}, "{v.name}", {v.lowest!r}, {v.highest!r}}}' for v in several if v.lowest is not None]
    return "{" + ", ".join(rows) + "}"


def _guid(several: Sequence[Variable]) -> str:
    digest = hashlib.sha256(repr((doc.version(), several)).encode()).hexdigest()
    return "{" + "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])) + "}"


def _compiler() -> str:
    given = os.environ.get("CC")
    found = next((name for name in (given, "cc", "gcc", "clang") if name and shutil.which(name.split()[0])), None)
    if found is None:
        raise ExchangeError("an FMU needs a C compiler to be made, none was found (CC, cc, gcc, clang): sudo apt-get install -y gcc")
    return found


def _link(compiler: str, objects: dict[str, bytes], header: str) -> bytes:
    source = resources.files("ddh_twin_py.exchange.fmu").joinpath("fmi2_slave.c").read_text("utf-8")
    with tempfile.TemporaryDirectory(prefix="ddh_fmu_") as scratch:
        folder = Path(scratch)
        (folder / "fmi2_slave.c").write_text(source, "utf-8")
        (folder / "ddh_model.h").write_text(header, "utf-8")
        (folder / "exports.map").write_text("{ global: fmi2*; local: *; };\n")
        for name, content in objects.items():
            (folder / f"{name}.o").write_bytes(content)
        target = folder / f"{IDENTIFIER}.so"
        command = [*compiler.split(), "-std=gnu11", "-O2", "-fPIC", "-shared", "-o", str(target), "fmi2_slave.c",
                   *(f"{name}.o" for name in objects), "-Wl,--version-script=exports.map", "-Wl,--no-undefined", "-s", "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        if done.returncode:
            lines = [line for line in done.stderr.splitlines() if "error" in line or "undefined" in line] or [f"{compiler} failed"]
            raise ExchangeError(f"the FMU's binary cannot be made: {' '.join(lines[0].split())}")
        return target.read_bytes()


def _documentation(rig: Rig, several: Sequence[Variable]) -> doc.Document:
    """Every variable, in the look of the reports."""
    page = doc.Document(
        kind="FMU", title=f"DDH twin {rig.rig_id}",
        verdict="Free run of the twin from speed command, payload and ambient; compiled, no Python is needed to run it.",
        end=doc.EndMatter("No recording takes part; parameters are the rig file's.", rig.file, ASSUMPTIONS),
    )
    columns = (
        doc.Column("Variable", number=False), doc.Column("Unit", number=False), doc.Column("Start"), doc.Column("Meaning", number=False),
    )
    for heading, groups in (("Inputs", (of.INPUT,)), ("Settings", (of.SETTING,)), ("Outputs", (of.OUTPUT, of.TEMPERATURE)),
                            ("Parameters of the rig", (of.PARAMETER,))):
        page.add(heading, doc.table(columns, [
            (v.name, v.unit, "" if v.start is None else f"{v.start:g}", v.about) for v in several if v.group in groups]))
    return page
