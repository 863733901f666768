"""Nodes and modes as a universal file: datasets 164, 15 and 55; masses as CSV beside it."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ....solver.errors import printable
from ....solver.math.arrays import Array
from ....solver.package import ModalPackage
from ....solver.package.common.temporary import write_text
from ..modal import write_masses

SUFFIX = ".uff"
COLOUR, GLOBAL = 1, 0


def write(package: ModalPackage, out: Path, source: Path) -> str:
    """Write SI units, nodes and one dataset 55 per mode (six numbers per node)."""
    text = "\n".join(line for block in _blocks(package) for line in ["    -1", *block, "    -1"])
    write_text(out, text + "\n", encoding="ascii")
    masses = write_masses(package, out)
    return f"{package.n_mode} modes at {len(package.nodes_B)} nodes; masses in {masses.name}"


def _blocks(package: ModalPackage) -> Iterator[list[str]]:
    units = f"{1:10d}{'SI: Meter (newton)':<20}{2:10d}"
    ones, zero = _numbers([1.0, 1.0, 1.0], "25.17E"), _numbers([273.15], "25.17E")
    yield ["   164", units, ones, zero]
    lines = ["    15"]
    for label, point in zip(package.node_ids, package.nodes_B, strict=True):
        lines.append(f"{label:10d}{GLOBAL:10d}{GLOBAL:10d}{COLOUR:10d}{_numbers(point)}")
    yield lines
    for i, shape in enumerate(package.shapes_B):
        yield list(_mode(package, i, shape))


def _mode(package: ModalPackage, i: int, shape: Array) -> Iterator[str]:
    label = package.mode_labels[i] if package.mode_labels else package.mode_kinds[i]
    w, damping = float(package.frequencies[i]), float(package.damping[i, i])
    ratio = damping / (2.0 * w * package.mass[i, i]) if w else 0.0
    yield "    55"
    yield from (printable(package.body)[:79], printable(label)[:79], "NONE", "NONE", "NONE")
    # structural model, normal mode, six dofs, displacement, real numbers, six per node
    yield "".join(f"{k:10d}" for k in (1, 2, 3, 8, 2, 6))
    yield "".join(f"{k:10d}" for k in (2, 4, 0, i + 1))
    yield _numbers([w / (2.0 * np.pi), package.mass[i, i], ratio, 0.0])
    for node, values in zip(package.node_ids, shape, strict=True):
        yield f"{node:10d}"
        yield _numbers(values)


def _numbers(values: Array | list[float], form: str = "13.5E") -> str:
    return "".join(f"{value:{form}}" for value in values)
