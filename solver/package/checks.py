"""What must hold before the solver may use a package: layout and numbers."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from ..errors import did_you_mean
from .container import is_text
from .layout import (
    BODY_LAYOUT,
    INTERFACE_LAYOUT,
    SECTION_LAYOUT,
    DatasetSpec,
    body_values,
    expected_shape,
    shape_text,
)
from .schema import MASS_FORMS, MODE_KINDS, REFERENCE_CONDITIONS, Array, ModalPackage, PackageError

SYMMETRY = 1e-9  # largest |K - K'| over largest |K|
INTERFACE_KINDS = ("node", "average")
Reporter = Callable[[str, str], None]  # takes dataset and message


@dataclass(frozen=True)
class Finding:
    """One remark on a package."""

    level: str  # error (unusable), warning (suspicious) or note
    dataset: str
    message: str


def layout_findings(group: h5py.Group) -> list[Finding]:
    """Compare the datasets of /modal_package with the format: presence, type, shape."""
    findings = _present(group, BODY_LAYOUT)
    defining = {"mesh/nodes_B": "n", "mesh/cell_types": "c", "mesh/connectivity": "i"}
    defining["modes/shapes_B"] = "m"
    sizes = {
        symbol: group[path].shape[0]
        for path, symbol in defining.items()
        if isinstance(group.get(path), h5py.Dataset) and group[path].ndim > 0
    }
    if len(sizes) == len(defining):
        findings += _shaped(group, BODY_LAYOUT, sizes)
    for parent, specs in (("interfaces", INTERFACE_LAYOUT), ("sections", SECTION_LAYOUT)):
        for name in group.get(parent, ()):
            sub = group[parent][name]
            if not isinstance(sub, h5py.Group):
                findings.append(Finding("error", sub.name, "expected a group"))
                continue
            findings += _present(sub, specs)
            ids = sub.get("node_ids")
            if len(sizes) == len(defining):
                k = {"k": ids.shape[0]} if isinstance(ids, h5py.Dataset) and ids.ndim else {}
                findings += _shaped(sub, specs, sizes | k)
    return findings


def content_findings(package: ModalPackage) -> list[Finding]:
    """Check the numbers that the solver relies on, of a package in memory."""
    bad: list[Finding] = []

    def error(dataset: str, message: str) -> None:
        bad.append(Finding("error", f"/modal_package/{dataset}", message))

    for path, value in body_values(package).items():
        _finite(path, value, error)
    for interface in package.interfaces:
        for name in ("weights", "position_B", "A_BI", "phi_B", "psi_B"):
            _finite(f"interfaces/{interface.name}/{name}", getattr(interface, name), error)
    for section in package.sections:
        for name in ("K", "M"):
            _finite(f"sections/{section.name}/{name}", getattr(section, name), error)
    if bad:
        return bad  # every other test would only repeat it

    for name in ("mass", "stiffness", "damping"):
        _symmetric(f"modes/{name}", getattr(package, name), error)
    _positive_mass(package.mass, error)
    if np.any(np.asarray(package.node_mass) < 0):
        row = int(np.argmin(package.node_mass))
        error("nodal/mass", f"expected masses >= 0, row {row} is {package.node_mass[row]:.6g} kg")
    if not package.invariants.mass > 0:
        error("invariants/mass", f"expected a mass > 0, found {package.invariants.mass:.6g} kg")

    _one_of("modes/kinds", package.mode_kinds, MODE_KINDS, error)
    _one_of("reference_condition", [package.reference_condition], REFERENCE_CONDITIONS, error)
    _one_of("invariants/mass_form", [package.invariants.mass_form], MASS_FORMS, error)
    _mesh(package, error)
    known = set(np.asarray(package.node_ids).tolist())
    if len(known) != len(package.node_ids):
        error("mesh/node_ids", "expected unique identifiers, some are there twice")
    for interface in package.interfaces:
        where = f"interfaces/{interface.name}"
        _one_of(f"{where}/kind", [interface.kind], INTERFACE_KINDS, error)
        unknown = sorted(set(np.asarray(interface.node_ids).tolist()) - known)
        if unknown:
            error(f"{where}/node_ids", f"no node has the identifier {unknown[0]}")
        A = np.asarray(interface.A_BI)
        if A.shape == (3, 3) and not (np.abs(A.T @ A - np.eye(3)).max() < 1e-9 < np.linalg.det(A)):
            error(f"{where}/A_BI", "expected a rotation matrix (orthonormal, determinant +1)")
    return bad


def raise_first(path: Path, findings: list[Finding]) -> None:
    """Raise the first error among findings as PackageError, saying how many follow."""
    errors = [f for f in findings if f.level == "error"]
    if errors:
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        raise PackageError(f"{path}: {errors[0].dataset}: {errors[0].message}{more}")


def _present(group: h5py.Group, specs: Iterable[DatasetSpec]) -> list[Finding]:
    found: list[str] = []
    group.visit(found.append)
    findings = []
    for spec in specs:
        item = group.get(spec.path)
        if item is None and spec.optional:
            continue
        where = f"{group.name}/{spec.path}"
        if not isinstance(item, h5py.Dataset):
            hint = did_you_mean(spec.path, found)
            text = f"missing; expected {spec.type} {shape_text(spec.shape)}{hint}"
            findings.append(Finding("error", where, text))
        elif is_text(item) != (spec.type == "text"):
            findings.append(Finding("error", where, f"expected {spec.type}, found {item.dtype}"))
        elif spec.type in ("int64", "uint8") and item.dtype.kind not in "iu":
            text = f"expected whole numbers ({spec.type}), found {item.dtype}"
            findings.append(Finding("error", where, text))
        elif spec.type == "float64" and item.dtype.kind not in "fiu":
            findings.append(Finding("error", where, f"expected float64, found {item.dtype}"))
    return findings


def _shaped(
    group: h5py.Group, specs: Iterable[DatasetSpec], sizes: dict[str, int]
) -> list[Finding]:
    findings = []
    for spec in specs:
        item = group.get(spec.path)
        if not isinstance(item, h5py.Dataset) or ("k" in spec.shape and "k" not in sizes):
            continue
        expected = expected_shape(spec, sizes)
        if item.shape != expected:
            symbols = shape_text(spec.shape)
            text = f"expected shape {symbols} = {expected}, found {item.shape}"
            findings.append(Finding("error", f"{group.name}/{spec.path}", text))
    return findings


def _finite(path: str, value: object, error: Reporter) -> None:
    array = np.asarray(value)
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        error(path, f"expected finite numbers, entry {list(index)} is {array[index]}")


def _symmetric(path: str, matrix: Array, error: Reporter) -> None:
    matrix = np.asarray(matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        return  # the layout check says it better
    gap = np.abs(matrix - matrix.T)
    if gap.max() > SYMMETRY * np.abs(matrix).max():
        i, j = (int(v) for v in np.unravel_index(np.argmax(gap), gap.shape))
        pair = f"entries [{i}, {j}] and [{j}, {i}] are {matrix[i, j]:.6g} and {matrix[j, i]:.6g}"
        error(path, f"expected a symmetric matrix, {pair}")


def _positive_mass(matrix: Array, error: Reporter) -> None:
    matrix = np.asarray(matrix)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        return
    try:
        values = np.linalg.eigvalsh((matrix + matrix.T) / 2)
    except np.linalg.LinAlgError as cause:
        error("modes/mass", f"its eigenvalues cannot be computed ({cause})")
        return
    if values[0] <= np.finfo(float).eps * len(values) * abs(values[-1]):
        text = f"expected a positive definite matrix, smallest eigenvalue is {values[0]:.6g}"
        error("modes/mass", text)


def _one_of(path: str, values: Iterable[str], known: tuple[str, ...], error: Reporter) -> None:
    for value in values:
        if value not in known:
            hint = did_you_mean(value, known)
            error(path, f"expected one of {', '.join(known)}, found {value!r}{hint}")


def _mesh(package: ModalPackage, error: Reporter) -> None:
    offsets, cells = np.asarray(package.offsets), np.asarray(package.connectivity)
    if len(offsets) and (
        offsets[0] != 0 or offsets[-1] != len(cells) or np.any(np.diff(offsets) < 0)
    ):
        error("mesh/offsets", f"expected 0 ... {len(cells)} in rising order")
    if len(cells) and (cells.min() < 0 or cells.max() >= len(package.nodes_B)):
        text = (
            f"expected rows 0 ... {len(package.nodes_B) - 1}, found {cells.min()} ... {cells.max()}"
        )
        error("mesh/connectivity", text)
