"""modelDescription.xml of an FMU: variables with units, what the library can do."""

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from datetime import UTC, datetime

from plymotion import __version__

from ....errors import InputError, printable
from ....run.coupled import Stepper
from ....run.coupled.stepper import DRIVE_ORDER, FORCE_ORDER

# Name in FMI, and exponents of the base units, by the unit of a signal.
UNITS: dict[str, tuple[str, dict[str, int]]] = {
    "m": ("m", {"m": 1}),
    "rad": ("rad", {"rad": 1}),
    "m/s": ("m/s", {"m": 1, "s": -1}),
    "rad/s": ("rad/s", {"rad": 1, "s": -1}),
    "m/s2": ("m/s2", {"m": 1, "s": -2}),
    "N": ("N", {"kg": 1, "m": 1, "s": -2}),
    "N m": ("N.m", {"kg": 1, "m": 2, "s": -2}),
    "Pa": ("Pa", {"kg": 1, "m": -1, "s": -2}),
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
    found = [
        Variable(given.name, given.unit, _meaning(given.drive), float(given.start[0]))
        for given in stepper.inputs
    ]
    for name, sensor in stepper.outputs.items():
        found.append(Variable(f"signals.{name}", sensor.unit, sensor.description, None))
    return found


def _meaning(drive: bool) -> str:
    return "value that the drive prescribes" if drive else "size of the force or torque"


def description(
    stepper: Stepper, identifier: str, guid: str, title: str, solver: tuple[float, float]
) -> bytes:
    """Return the XML text.

    Parameters
    ----------
    identifier : name of the library
    title : modelName
    solver : end of the run and interval of its outputs [s], as defaults of the experiment
    """
    variables = variables_of(stepper)
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=_words(title),
        guid=guid,
        description="Flexible multibody mechanism; needs Plymotion on the machine that runs it",
        generationTool=f"Plymotion {__version__}",
        generationDateAndTime=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        variableNamingConvention="flat",
    )
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=identifier,
        needsExecutionTool="true",
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="true",
        canNotUseMemoryManagementFunctions="true",
    )
    _units(ET.SubElement(root, "UnitDefinitions"), variables)
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
    outputs = _model_variables(ET.SubElement(root, "ModelVariables"), variables)
    structure = ET.SubElement(root, "ModelStructure")
    for part in ("Outputs", "InitialUnknowns") if outputs else ():
        unknowns = ET.SubElement(structure, part)
        for index in outputs:
            ET.SubElement(unknowns, "Unknown", index=str(index))
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="UTF-8", xml_declaration=True)) + b"\n"


def _words(text: str) -> str:
    """Return a text of the user in one line, without characters that XML does not have."""
    return printable(" ".join(text.split()))


def _units(parent: ET.Element, variables: list[Variable]) -> None:
    for unit in dict.fromkeys(variable.unit for variable in variables):
        if unit not in UNITS:
            raise InputError(f"unit {unit!r} of a signal: expected one of {', '.join(UNITS)}")
        name, exponents = UNITS[unit]
        element = ET.SubElement(parent, "Unit", name=name)
        ET.SubElement(element, "BaseUnit", {base: str(n) for base, n in exponents.items()})
        if unit in DEGREES:
            shown, factor = DEGREES[unit]
            ET.SubElement(element, "DisplayUnit", name=shown, factor=repr(factor))


def _model_variables(parent: ET.Element, variables: list[Variable]) -> list[int]:
    """Add the variables, then the parameters; return the places of the outputs, from 1."""
    outputs = []
    for reference, variable in enumerate(variables):
        causality = "output" if variable.start is None else "input"
        scalar = ET.SubElement(
            parent,
            "ScalarVariable",
            name=variable.name,
            valueReference=str(reference),
            causality=causality,
            variability="continuous",
        )
        if variable.description:
            scalar.set("description", _words(variable.description))
        real = ET.SubElement(scalar, "Real", unit=UNITS[variable.unit][0])
        if variable.start is None:
            scalar.set("initial", "calculated")
            outputs.append(reference + 1)
        else:
            real.set("start", repr(variable.start))
    for reference, (name, usual) in enumerate(
        (("drive_order", DRIVE_ORDER), ("force_order", FORCE_ORDER))
    ):
        scalar = ET.SubElement(
            parent,
            "ScalarVariable",
            name=name,
            valueReference=str(reference),
            causality="parameter",
            variability="fixed",
            initial="exact",
            description="of the polynomial that carries an input on during a step",
        )
        ET.SubElement(scalar, "Integer", start=str(usual), min="0", max="2")
    return outputs
