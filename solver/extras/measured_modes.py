"""Modal packages from measured modes (the paper, section 2.3): the files of a modal test."""

import csv
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import model_validator

from plymotion import __version__

from ..errors import InputError, nearest
from ..inputs.common.input_table import Name, Table, entry, optional, validated
from ..inputs.common.text_file import read_toml
from ..math.arrays import Array, IntArray
from ..math.disk_cache import file_sha256
from ..package.body.measured import Measurement, experimental_package
from ..package.body.package_schema import ModalPackage

# Every key of a file of measured modes (docs/modes.md).


class MeasuredReference(Table):
    """`[reference]`: support of the body in the test; it defines the reference condition."""

    kind: Literal["clamped", "mean-axis"] = entry(
        "clamped: one interface was fixed to a rig; mean-axis: the body was free"
    )
    at: Name | None = optional("interface that was held, if clamped")

    @model_validator(mode="after")
    def _place(self) -> "MeasuredReference":
        if (self.kind == "clamped") != (self.at is not None):
            raise ValueError("expected `at` with an interface if clamped, no `at` if mean-axis")
        return self


class MeasuredMode(Table):
    """`[[modes]]`: one measured mode."""

    frequency_hz: float = entry("natural frequency", "Hz", gt=0)
    shape: str = entry("CSV file: node, ux, uy, uz and rx, ry, rz where measured; any scale")
    damping_ratio: float = entry("fraction of critical", "-", 0.0, ge=0, lt=1)
    label: str = entry("name in results; absent: name of the shape's file", default="")


class MeasuredInterface(Table):
    """`[interfaces.NAME]`: where joints, masses and signals attach."""

    nodes: list[int] = entry("nodes of the interface; its motion is their mean", min_length=1)


class MeasuredFile(Table):
    """The top of the file."""

    format: Literal[1] = entry("version of this format")
    body: str = entry("name of the body", min_length=1)
    title: str = entry("description of the test, one line", default="")
    nodes: str = entry(
        "CSV file: node, x, y, z [m], mass [kg] and Jxx, Jyy, Jzz, Jxy, Jxz, Jyz [kg m2] about "
        "the node where known"
    )
    lines: list[list[int]] = entry(
        "nodes connected by lines in pictures, one list for each line", default=[]
    )
    mass_normalised: bool = entry(
        "shapes have unit modal mass; compared with the nodal masses", default=False
    )
    reference: MeasuredReference = entry("support in the test")
    modes: list[MeasuredMode] = entry("measured modes", min_length=1)
    interfaces: dict[Name, MeasuredInterface] = entry("named places", min_length=1)


# Columns of numbers from a CSV file with the names in its first line.


def read_columns(
    file: Path, required: tuple[str, ...], optional: tuple[str, ...]
) -> tuple[IntArray, dict[str, Array]]:
    """Node numbers (n,) of the column `node`, and the other columns by name, (n,) each.

    Empty lines and lines that begin with # are ignored. Values are separated by commas or, if the
    first line contains any, by semicolons.

    Parameters
    ----------
    file : table of numbers (CSV)
    required : names of columns besides `node`
    optional : names of columns that may be absent

    Raises
    ------
    InputError : no such file; a column is unknown or missing; a value is not a number; a node
        occurs twice. Names file, line and column.
    """
    rows = _rows(file)
    head_line, head = rows[0]
    known = ("node", *required, *optional)
    for name in head:
        if name not in known:
            raise InputError(f"{file}:{head_line}: column {name!r}: unknown{nearest(name, known)}")
        if head.count(name) > 1:
            raise InputError(f"{file}:{head_line}: column {name!r}: occurs twice")
    for name in ("node", *required):
        if name not in head:
            raise InputError(
                f"{file}:{head_line}: column {name!r}: missing; expected a first line that names "
                f"it, found {', '.join(head)}"
            )
    numbers = np.empty((len(rows) - 1, len(head)))
    for k, (line, texts) in enumerate(rows[1:]):
        if len(texts) != len(head):
            raise InputError(f"{file}:{line}: expected {len(head)} values, found {len(texts)}")
        for j, text in enumerate(texts):
            numbers[k, j] = _number(file, line, head[j], text)
    columns = {name: numbers[:, j] for j, name in enumerate(head)}
    nodes = columns.pop("node").astype(np.int64)
    for k in range(1, len(nodes)):
        if nodes[k] in nodes[:k]:
            raise InputError(f"{file}:{rows[k + 1][0]}: node {nodes[k]} occurs twice")
    return nodes, columns


def _rows(file: Path) -> list[tuple[int, list[str]]]:
    """Numbered non-empty lines, split into stripped texts."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (FileNotFoundError, IsADirectoryError) as error:
        raise InputError(f"{file}: no such file") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{file}: expected text in UTF-8 ({error})") from error
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip(" ,;\t") and not line.lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise InputError(f"{file}: expected a line of names and a line for each node")
    separator = ";" if ";" in lines[0][1] else ","
    reader = csv.reader((line for _, line in lines), delimiter=separator, skipinitialspace=True)
    return [
        (number, [text.strip() for text in texts])
        for (number, _), texts in zip(lines, reader, strict=True)
    ]


def _number(file: Path, line: int, column: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value) or (column == "node" and value != round(value)):
        expectation = "a whole number" if column == "node" else "a number with a decimal point"
        raise InputError(
            f"{file}:{line}: column {column!r}: expected {expectation}, found {text!r}"
        )
    return value


# Read a modal test: nodes with masses, frequencies, shapes, interfaces.

INERTIAS = {
    "Jxx": (0, 0),
    "Jyy": (1, 1),
    "Jzz": (2, 2),
    "Jxy": (0, 1),
    "Jxz": (0, 2),
    "Jyz": (1, 2),
}
TRANSLATIONS, ROTATIONS = ("ux", "uy", "uz"), ("rx", "ry", "rz")


def measured_package(file: Path) -> ModalPackage:
    """Read a file of measured modes and its CSV files; return the package of the body.

    Raises
    ------
    InputError : names file, key or line and column, value and expectation.
    """
    table = read_toml(file, "file of measured modes")
    keys = validated(MeasuredFile, table, file)
    nodes_file = file.parent / keys.nodes
    node_ids, columns = read_columns(nodes_file, ("x", "y", "z", "mass"), tuple(INERTIAS))
    if not (columns["mass"] >= 0.0).all() or not columns["mass"].sum() > 0.0:
        raise InputError(f"{nodes_file}: column 'mass': expected masses >= 0 with a sum > 0")
    problems = _unknown_nodes(file, keys, node_ids)
    if problems:
        raise InputError("\n".join(problems))
    inertia = np.zeros((len(node_ids), 3, 3))
    for name, (i, j) in INERTIAS.items():
        inertia[:, i, j] = inertia[:, j, i] = columns.get(name, 0.0)
    held = keys.interfaces[keys.reference.at].nodes if keys.reference.at else []
    modes = sorted(keys.modes, key=lambda mode: mode.frequency_hz)
    shapes, has_rotations = [], True
    for mode in modes:
        shape, complete = _shape(file.parent / mode.shape, node_ids, held)
        shapes.append(shape)
        has_rotations = has_rotations and complete
    names = [file.name, keys.nodes, *(mode.shape for mode in modes)]
    row = {int(node): k for k, node in enumerate(node_ids)}
    measurement = Measurement(
        body=keys.body,
        held=keys.reference.at,
        interfaces={
            name: np.array([row[node] for node in place.nodes])
            for name, place in keys.interfaces.items()
        },
        lines=[[row[node] for node in nodes] for nodes in keys.lines],
        node_ids=node_ids,
        nodes_B=np.column_stack([columns[axis] for axis in "xyz"]),
        node_mass=columns["mass"],
        node_inertia_B=inertia,
        shapes_B=np.array(shapes),
        has_rotations=has_rotations,
        frequencies=2.0 * np.pi * np.array([mode.frequency_hz for mode in modes]),
        damping_ratios=np.array([mode.damping_ratio for mode in modes]),
        labels=tuple(mode.label or Path(mode.shape).stem for mode in modes),
        mass_normalised=keys.mass_normalised,
    )
    provenance = {
        "plymotion": __version__,
        "command": "plymotion import",
        "title": keys.title,
        "files_sha256": {name: file_sha256(file.parent / name) for name in names},
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    return experimental_package(measurement, provenance)


def _unknown_nodes(file: Path, keys: MeasuredFile, node_ids: IntArray) -> list[str]:
    """Return one message for each unknown node or interface."""
    known = set(node_ids.tolist())
    named = [(f"lines[{i}]", nodes) for i, nodes in enumerate(keys.lines)]
    named += [(f"interfaces.{n}.nodes", i.nodes) for n, i in keys.interfaces.items()]
    errors = [
        f"{file}: {key} = {nodes}: {keys.nodes} has no node {node}"
        for key, nodes in named
        for node in nodes
        if node not in known
    ]
    at = keys.reference.at
    if at is not None and at not in keys.interfaces:
        hint = nearest(at, keys.interfaces)
        errors.append(f'{file}: reference.at = "{at}": no such interface{hint}')
    return errors


def _shape(file: Path, node_ids: IntArray, held: list[int]) -> tuple[Array, bool]:
    """Shape (n, 6) from a file, zero for missing columns; whether it has all rotations.

    Nodes in `held` were held and may be omitted.
    """
    ids, columns = read_columns(file, (), TRANSLATIONS + ROTATIONS)
    if not any(name in columns for name in TRANSLATIONS):
        raise InputError(f"{file}: expected a column {', '.join(TRANSLATIONS)}, or several")
    known, measured = node_ids.tolist(), ids.tolist()
    unknown = sorted(set(measured) - set(known))
    missing = sorted(set(known) - set(measured) - set(held))
    if unknown:
        raise InputError(f"{file}: node {unknown[0]}: expected one of the nodes of the test")
    if missing:
        raise InputError(
            f"{file}: node {missing[0]}{' and others' if len(missing) > 1 else ''}: missing; "
            "expected every node of the test"
        )
    shape = np.zeros((len(known), 6))
    rows = [known.index(node) for node in measured]
    for j, name in enumerate(TRANSLATIONS + ROTATIONS):
        shape[rows, j] = columns.get(name, 0.0)
    if not np.abs(shape[:, :3]).max() > 0.0:
        raise InputError(f"{file}: expected a non-zero shape, found only zeros")
    return shape, all(name in columns for name in ROTATIONS)
