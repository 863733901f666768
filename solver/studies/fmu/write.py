"""Write an FMU: description, library for this machine, run and packages, in one archive."""

import hashlib
import json
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import plymotion
from plymotion import __version__

from ...errors import InputError, printable
from ...inputs.case.record import package_entries
from ...mechanism.python_functions import codes_of
from ...package.common.files import temporary_sibling
from ...run.coupled import DRIVE_ORDER, FORCE_ORDER, Stepper
from ...run.execution import read_run
from ..sensitivities.differentiated_run import require_derivatives
from . import VERSIONS

# modelDescription.xml of an FMU: variables with units, what the library can do.

# Name in FMI, and exponents of the base units, by the unit of a signal.
UNITS: dict[str, tuple[str, dict[str, int]]] = {
    "m": ("m", {"m": 1}),
    "rad": ("rad", {"rad": 1}),
    "s": ("s", {"s": 1}),
    "m/s": ("m/s", {"m": 1, "s": -1}),
    "rad/s": ("rad/s", {"rad": 1, "s": -1}),
    "m/s2": ("m/s2", {"m": 1, "s": -2}),
    "N": ("N", {"kg": 1, "m": 1, "s": -2}),
    "N m": ("N.m", {"kg": 1, "m": 2, "s": -2}),
    "Pa": ("Pa", {"kg": 1, "m": -1, "s": -2}),
    "W": ("W", {"kg": 1, "m": 2, "s": -3}),
    "-": ("1", {}),
}
DEGREES = {"rad": ("deg", 57.29577951308232), "rad/s": ("deg/s", 57.29577951308232)}


@dataclass(frozen=True)
class Variable:
    """One Real variable; its value reference is its place in the list."""

    name: str
    unit: str
    description: str
    start: float | None  # of an input; None: an output


def variables_of(stepper: Stepper) -> list[Variable]:
    """Return the inputs, then the outputs."""
    variables = []
    for given in stepper.inputs:
        meaning = (
            "value that the drive prescribes" if given.drive else "size of the force or torque"
        )
        variables.append(Variable(given.name, given.unit, meaning, float(given.start[0])))
    for name, sensor in stepper.outputs.items():
        variables.append(Variable(f"signals.{name}", sensor.unit, sensor.description, None))
    return variables


def derivatives_refused(stepper: Stepper) -> str:
    """Return why outputs have no derivatives by inputs, or nothing."""
    try:
        require_derivatives(stepper.prepared)
    except InputError as error:
        return str(error)
    return ""


def description(
    stepper: Stepper,
    identifier: str,
    guid: str,
    title: str,
    solver: tuple[float, float],
    version: str,
) -> bytes:
    """Return the XML text.

    Parameters
    ----------
    identifier : name of the library
    title : modelName
    solver : end of the run and interval of its outputs [s], as defaults of the experiment
    version : of FMI, "2.0" or "3.0"
    """
    variables, old = variables_of(stepper), version == "2.0"
    differentiable = not derivatives_refused(stepper)
    root = ET.Element(
        "fmiModelDescription",
        {"fmiVersion": version, "guid" if old else "instantiationToken": guid},
        modelName=_words(title),
        description="Flexible multibody mechanism; needs Plymotion on the machine that runs it",
        generationTool=f"Plymotion {__version__}",
        generationDateAndTime=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        variableNamingConvention="flat",
    )
    able: dict[str, bool] = {
        "needsExecutionTool": True,
        "canHandleVariableCommunicationStepSize": True,
    }
    if old:
        able |= {"canInterpolateInputs": True, "canNotUseMemoryManagementFunctions": True}
        able |= {"canGetAndSetFMUstate": True, "providesDirectionalDerivative": differentiable}
    else:
        able |= {"canGetAndSetFMUState": True, "providesDirectionalDerivatives": differentiable}
        able |= {"providesAdjointDerivatives": differentiable, "hasEventMode": True}
    flags = {name: "true" for name, value in able.items() if value}
    ET.SubElement(root, "CoSimulation", flags, modelIdentifier=identifier)
    used = [variable.unit for variable in variables] + ([] if old else ["s"])
    _units(ET.SubElement(root, "UnitDefinitions"), used)
    categories = ET.SubElement(root, "LogCategories")
    for category in ("logStatusWarning", "logStatusError"):
        ET.SubElement(categories, "Category", name=category)
    end, interval = solver
    ET.SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=repr(end),
        stepSize=repr(interval),
    )
    _model_variables(ET.SubElement(root, "ModelVariables"), variables, old=old)
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [k for k, variable in enumerate(variables) if variable.start is None]
    for part in ("Output", "InitialUnknown") if outputs else ():
        parent = ET.SubElement(structure, f"{part}s") if old else structure
        for k in outputs:
            if old:
                ET.SubElement(parent, "Unknown", index=str(k + 1))
            else:
                ET.SubElement(parent, part, valueReference=str(k))
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"


def _words(text: str) -> str:
    """Return a text of the user in one line, without characters that XML does not have."""
    return printable(" ".join(text.split()))


def _units(parent: ET.Element, used: list[str]) -> None:
    for unit in dict.fromkeys(used):
        if unit not in UNITS:
            raise InputError(f"unit {unit!r} of a signal: expected one of {', '.join(UNITS)}")
        name, exponents = UNITS[unit]
        element = ET.SubElement(parent, "Unit", name=name)
        ET.SubElement(element, "BaseUnit", {base: str(n) for base, n in exponents.items()})
        if unit in DEGREES:
            shown, factor = DEGREES[unit]
            ET.SubElement(element, "DisplayUnit", name=shown, factor=repr(factor))


def _model_variables(parent: ET.Element, variables: list[Variable], *, old: bool) -> None:
    """Add the variables, then the parameters and, by FMI 3, the time."""
    real, whole = ("Real", "Integer") if old else ("Float64", "Int32")

    def add(name: str, kind: str, own: dict[str, str], description: str, **values: str) -> None:
        """Add one; by FMI 2 the values of its kind stand in an element of their own."""
        number = str(len(parent))
        more = {"description": _words(description)} if description else {}
        if old:
            common = {"name": name, "valueReference": number, **more, **own}
            ET.SubElement(ET.SubElement(parent, "ScalarVariable", common), kind, values)
        else:
            ET.SubElement(
                parent, kind, {"name": name, "valueReference": number, **more, **own, **values}
            )

    for variable in variables:
        causality = "output" if variable.start is None else "input"
        own = {"causality": causality, "variability": "continuous"}
        values = {"unit": UNITS[variable.unit][0]}
        if variable.start is None:
            own["initial"] = "calculated"
        else:
            values["start"] = repr(variable.start)
        add(variable.name, real, own, variable.description, **values)
    description = "of the polynomial that carries an input on during a step"
    for name, usual in (("drive_order", DRIVE_ORDER), ("force_order", FORCE_ORDER)):
        own = {"causality": "parameter", "variability": "fixed", "initial": "exact"}
        add(name, whole, own, description, start=str(usual), min="0", max="2")
    if not old:
        own = {"causality": "independent", "variability": "continuous"}
        add("time", real, own, "", unit="s")


# Folder `resources` of an FMU: the run, its packages, names of the inputs, where the solver is.
#
# runs/RUN.json           as `check` wrote it, with packages of this folder
# bodies/*.vtkhdf         each package once
# inputs.txt              one name per line, in the order of their value references
# solver.txt              the Python interpreter; the folder of a checkout, or nothing

INPUTS, SOLVER = "inputs.txt", "solver.txt"


def run_of(folder: Path) -> Path:
    """Return the run file. Raises InputError if there is none, or more than one."""
    files = list((folder / "runs").glob("*.json"))
    if len(files) != 1:
        raise InputError(f"{folder}: resources of an FMU: expected one run, found {len(files)}")
    return files[0]


def write_contents(run_file: Path, folder: Path) -> Path:
    """Write run and packages into `folder`; return the run file there."""
    table = json.loads(run_file.read_text(encoding="utf-8"))
    (folder / "bodies").mkdir(parents=True)
    (folder / "runs").mkdir()
    table.pop("check_packages", None)
    copied: dict[str, str] = {}  # one copy of a package that several bodies or runs share
    for entry in package_entries(table):
        file = entry["file"]
        if file not in copied:
            copied[file] = f"bodies/{len(copied)}-{Path(file).name}"
            shutil.copyfile(run_file.parent.parent / file, folder / copied[file])
        entry["file"] = copied[file]
    run = folder / "runs" / run_file.name
    run.write_text(json.dumps(table), encoding="utf-8")
    package = Path(plymotion.__file__).resolve().parent
    checkout = (package.parent / "pyproject.toml").is_file()
    home = str(package.parent) if checkout else ""
    (folder / SOLVER).write_text(f"{sys.executable}\n{home}\n", encoding="utf-8")
    return run


# Write an FMU: description, library for this machine, run and packages, in one archive.

LIBRARY = Path(__file__).with_name("library.c")
PLATFORMS = {  # folder by FMI 2, by FMI 3, ending
    ("Linux", "x86_64"): ("linux64", "x86_64-linux", ".so"),
    ("Linux", "aarch64"): ("aarch64-linux", "aarch64-linux", ".so"),
    ("Darwin", "x86_64"): ("darwin64", "x86_64-darwin", ".dylib"),
    ("Darwin", "arm64"): ("aarch64-darwin", "aarch64-darwin", ".dylib"),
}


def write_fmu(
    run_file: Path, out: Path, inputs: Sequence[str] | None = None, target: str = "fmu"
) -> Stepper:
    """Write the FMU of a run file of `check`, whose packages are built.

    Parameters
    ----------
    inputs : names of drives and forces that are inputs; None: all
    target : of `VERSIONS`

    Raises
    ------
    InputError
        No C compiler, another operating system, a run that cannot be made an FMU.
    """
    with tempfile.TemporaryDirectory(prefix="plymotion-") as name:
        folder = Path(name)
        resources = folder / "resources"
        run = write_contents(run_file, resources)
        spec = read_run(run)
        for name in codes_of(spec.mechanism):
            raise InputError(
                f"forces.{name}.code: an FMU does not run Python files of the user; expected a "
                "controller or an expression"
            )
        stepper = Stepper(spec, inputs)
        names = "".join(f"{given.name}\n" for given in stepper.inputs)
        (resources / INPUTS).write_text(names, encoding="utf-8")
        title = f"{spec.case}, {spec.run}"
        identifier = re.sub(r"\W", "_", f"{spec.case}_{spec.run}", flags=re.ASCII)
        identifier = identifier if identifier[0].isalpha() else f"m_{identifier}"
        solver = spec.mechanism.solver
        times = float(solver.t_end), float(solver.output_step)
        digest = hashlib.sha256()  # the same for the same contents
        for file in _files(resources):
            digest.update(file.relative_to(resources).as_posix().encode() + file.read_bytes())
        d = digest.hexdigest()
        guid = f"{{{d[:8]}-{d[8:12]}-{d[12:16]}-{d[16:20]}-{d[20:32]}}}"
        text = description(stepper, identifier, guid, title, times, VERSIONS[target])
        (folder / "modelDescription.xml").write_bytes(text)
        _compile(folder / "binaries", identifier, guid, target)
        out.parent.mkdir(parents=True, exist_ok=True)
        with (
            temporary_sibling(out) as temporary,
            zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive,
        ):
            for file in _files(folder):
                archive.write(file, file.relative_to(folder).as_posix())
    return stepper


def _compile(folder: Path, identifier: str, guid: str, version: str) -> None:
    machine = platform.system(), platform.machine()
    if machine not in PLATFORMS:
        known = ", ".join(" ".join(pair) for pair in PLATFORMS)
        raise InputError(f"--to fmu: {' '.join(machine)}: expected one of {known}")
    *places, suffix = PLATFORMS[machine]
    place = places[list(VERSIONS).index(version)]
    target = folder / place / f"{identifier}{suffix}"
    target.parent.mkdir(parents=True)
    compiler = shlex.split(os.environ.get("CC") or "cc")
    options = ["-O2", "-shared", "-fPIC", "-fvisibility=hidden", "-D_GNU_SOURCE"]
    command = [*compiler, *options, f'-DGUID="{guid}"', str(LIBRARY), "-o", str(target), "-lm"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise InputError(
            f"--to fmu: {compiler[0]}: {error.strerror}; expected a C compiler, cc or that of "
            "the variable CC"
        ) from error
    if done.returncode != 0:
        raise InputError(f"--to fmu: {compiler[0]} fails: {done.stderr.strip()[-1000:]}")


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())
