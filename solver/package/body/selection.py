"""Other modes from those of a package: a change of basis, q = T q', and the modes of requests.

All data of a package are sums over stations of products of shapes. A change of the modal
coordinates acts on each of their modal axes with T, exact to round-off. A subset of the modes, and
static shapes rebuilt as combinations of all modes, therefore need no new package.

Static modes of a package are the parts of the static shapes that its vibrations leave. Without one
of the vibrations they have a hole. A static shape is therefore rebuilt as K^-1 p from all modes of
the package, with the modal load p, and its part along the vibrations that are kept is removed
again. The modal load follows from the shapes at the interfaces and from the inertia invariants.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...errors import PackageError, did_you_mean
from ...math.arrays import Array, IntArray
from ..common.dataset import all_values, rebuilt, shapes_by_path
from ..common.design import Derivative, changed
from ..specification import DIRECTIONS
from .package_schema import ModalPackage


def changed_basis(
    package: ModalPackage,
    T: Array,
    labels: tuple[str, ...] = (),
    kinds: tuple[str, ...] = (),
    damping: Array | None = None,
) -> ModalPackage:
    """Return the package in modal coordinates q', q = T q'.

    Parameters
    ----------
    T : (m, k), independent columns; k = 0 gives the rigid body with its true mass and inertia
    labels, kinds : k of the new modes; absent: those of the largest share of each column
    damping : (k, k) new modal damping; None: T' D T  [N m s]
    """
    m, k = T.shape
    if not k:
        places = (replace(place, H_B=None, H_psi_B=None) for place in package.interfaces)
        package = replace(package, interfaces=tuple(places), second_order=None)
    largest = np.argmax(np.abs(T), axis=0) if k else np.zeros(0, dtype=np.int64)
    some = np.array_equal(T, np.eye(m)[:, largest])  # of the modes, as they are

    def change(shape: str, A: Array) -> Array:
        axes = [axis for axis, size in enumerate(shape.split(", ")) if size == "m"]
        for axis in axes:
            if some:
                A = A.take(largest, axis)
            else:
                A = np.moveaxis(np.tensordot(A, T, (axis, 0)), -1, axis)
        if len(axes) == 4 and not some:
            A = 0.5 * (A + A.transpose(2, 3, 0, 1))  # to the last bit: the format asks it
        return np.ascontiguousarray(A) if axes else A

    shapes = shapes_by_path(package)
    values = {
        path: change(shapes[path], value) if isinstance(value, np.ndarray) else value
        for path, value in all_values(package).items()
    }
    changed, known = rebuilt(package, values), package.mode_labels or package.mode_kinds
    return replace(
        changed,
        mode_kinds=kinds or tuple(package.mode_kinds[i] for i in largest),
        mode_labels=labels or tuple(known[i] for i in largest),
        design=_design(package, largest if some else None, change),
        frequencies=np.sqrt(np.maximum(np.diag(changed.stiffness), 0.0) / np.diag(changed.mass)),
        damping=changed.damping if damping is None else damping,
    )


def _design(
    package: ModalPackage, kept: IntArray | None, change: Callable[[str, Array], Array]
) -> tuple[Derivative, ...]:
    """Derivatives of the package with some of its modes; `kept` None: with combinations of them.

    Raises PackageError for a derivative that is lost: by a parameter that turns a kept mode into
    one of equal frequency that is left out, and those of combinations, which change with the
    design.
    """
    for one in package.design:
        rate = one.values.get("modes/stiffness")
        if kept is None:
            why = "its modes are new combinations"
        elif rate is None or not np.delete(rate[kept], kept, axis=1).any():
            continue
        else:
            why = "it turns a mode into one of equal frequency that is left out"
        raise PackageError(
            f"{package.body}: the package has derivatives by {one.name}, but a selection of its "
            f"modes does not: {why}; expected the modes that `modes` of the body asks for"
        )
    return changed(package.design, change, shapes_by_path(package))


def rigid(package: ModalPackage) -> ModalPackage:
    """Return the body without its modes: rigid, of the same mass and inertia."""
    return changed_basis(package, np.zeros((package.n_mode, 0)))


DEPENDENT = 1e-6  # energy norm of the new part of a shape, relative to that of the whole shape
# Labels of the vibrations of shells, by kind.
ALONG = {"bending-xy": "along y", "bending-xz": "along z", "axial": "along x"}
INERTIA_LABELS = tuple(f"inertia {direction}" for direction in DIRECTIONS)


def vibrations(package: ModalPackage) -> IntArray:
    """Rows of the vibration modes, in the order of the package."""
    static = ("attachment", "constraint", "residual")
    indices = [i for i, kind in enumerate(package.mode_kinds) if kind not in static]
    return np.array(indices, dtype=np.int64)


def inertia_loads(package: ModalPackage) -> Array:
    """Modal loads (m, 6) of a rigid acceleration of the frame along and about its axes.

    Those of unit accelerations, M_qv and M_qw of the undeformed body: K^-1 of them are the shapes
    under inertia loads.
    """
    inv = package.invariants
    T = inv.T01_B
    about = np.array([T[1, 2] - T[2, 1], T[2, 0] - T[0, 2], T[0, 1] - T[1, 0]]) + inv.J_psi_B
    return np.concatenate([inv.S_B, about]).T


def interface_load(package: ModalPackage, at: str, direction: str) -> Array:
    """Modal load (m,) of a unit force along, or moment about, a body axis at an interface.

    Parameters
    ----------
    package : the modal package
    at : name of an interface
    direction : "x", "y", "z", "rx", "ry" or "rz" of the body

    Raises PackageError for an interface that the package does not have.
    """
    places = {place.name: place for place in package.interfaces}
    if at not in places:
        known = did_you_mean(at, places)
        raise PackageError(f'{package.body}: no interface "{at}" in the package{known}')
    row = DIRECTIONS.index(direction)  # type: ignore[arg-type]
    return np.asarray((places[at].phi_B if row < 3 else places[at].psi_B)[row % 3])


def axial_load(package: ModalPackage) -> Array:
    """Modal load (m,) of a load per mass that grows with x: that of a unit spin across x."""
    return np.asarray(package.invariants.T01_B[0, 0])


def with_statics(
    package: ModalPackage,
    kept: Sequence[int] | IntArray,
    loads: Array,
    load_labels: Sequence[str] = (),
    damping_ratio: float | None = None,
) -> ModalPackage:
    """Return the package with some of its vibrations and the static shapes of loads.

    Parameters
    ----------
    kept : rows of the vibrations that stay
    loads : (m, k) modal loads; each adds the shape K^-1 p without its part along `kept` and along
        the shapes of earlier loads; a shape that is nothing new adds no mode
    load_labels : k names of the loads
    damping_ratio : of the static modes; None: that of all modes of the package, if they have one
        in common, otherwise its damping matrix in the new modes
    """
    kept = np.asarray(kept, dtype=np.int64)
    unit = np.eye(package.n_mode)[:, kept]
    K, M = package.stiffness, package.mass
    known = package.mode_labels or package.mode_kinds
    labels = [known[i] for i in kept]
    kinds = [package.mode_kinds[i] for i in kept]
    shapes = np.asarray(np.linalg.solve(K, loads)) if loads.size else np.zeros_like(loads)
    shapes_added, named = _independent(K, unit, shapes)
    if shapes_added.shape[1]:
        shapes_added = shapes_added - unit @ np.linalg.solve(
            unit.T @ M @ unit, unit.T @ M @ shapes_added
        )
        # Their stiffness is 1: natural modes follow from the mass alone.
        energy = np.sqrt((shapes_added * (K @ shapes_added)).sum(axis=0))
        inverse, V = np.linalg.eigh((shapes_added / energy).T @ M @ (shapes_added / energy))
        shapes_added, values = (
            (shapes_added / energy @ V / np.sqrt(inverse))[:, ::-1],
            1.0 / inverse[::-1],
        )
        labels += [str(load_labels[i]) if load_labels else f"static {i + 1}" for i in named]
        kinds += ["attachment"] * len(named)
    T = np.hstack([unit, shapes_added])
    damping = T.T @ package.damping @ T
    if damping_ratio is None:
        damping_ratio = common_damping_ratio(package)
    if damping_ratio is not None and shapes_added.shape[1]:
        n = len(kept)
        damping[n:], damping[:, n:] = 0.0, 0.0
        damping[n:, n:] = np.diag(2.0 * damping_ratio * np.sqrt(values))
    return changed_basis(package, T, tuple(labels), tuple(kinds), damping)


def common_damping_ratio(package: ModalPackage) -> float | None:
    """Return the damping ratio that all modes of a package have; None if they differ."""
    D = package.damping
    if not package.n_mode or np.count_nonzero(D - np.diag(np.diag(D))):
        return None
    ratios = np.diag(D) / (2.0 * package.frequencies * np.diag(package.mass))
    same = np.ptp(ratios) <= 1e-9 * np.abs(ratios).max(initial=0.0)
    return float(ratios[0]) if same else None


def _independent(K: Array, basis: Array, shapes: Array) -> tuple[Array, list[int]]:
    """New part of each shape, energy-orthogonal to a basis and to earlier ones, of unit energy."""
    root = np.linalg.cholesky(K).T
    Q = np.linalg.qr(root @ basis)[0] if basis.shape[1] else np.zeros((len(K), 0))
    columns, kept = [], []
    for i in range(shapes.shape[1]):
        x = root @ shapes[:, i]
        size = float(np.linalg.norm(x))
        if size == 0.0:
            continue
        x = x / size
        for _ in range(2):  # the second pass removes the round-off of the first
            x = x - Q @ (Q.T @ x)
        left = float(np.linalg.norm(x))
        if left > DEPENDENT:
            Q = np.column_stack([Q, x / left])
            columns.append(np.linalg.solve(root, x / left))
            kept.append(i)
    return (np.column_stack(columns) if columns else np.zeros((len(K), 0))), kept


def selected(package: ModalPackage, requests: Sequence[Mapping[str, Any]]) -> ModalPackage:
    """Return the package with the requested modes only, as `modes` of a body asks for them.

    Parameters
    ----------
    requests : tables with `kind` and `count` of vibrations, or `kind` "attachment" with `at` and
        `directions`, or "static-axial", or "static-inertia"

    Raises
    ------
    PackageError
        The package has fewer vibrations of a kind, or no such interface.
    """
    rows = vibrations(package)
    known = package.mode_labels or package.mode_kinds
    kept: list[int] = []
    loads: list[Array] = []
    labels: list[str] = []
    for table in requests:
        kind = table["kind"]
        if kind == "attachment":
            for direction in table["directions"]:
                loads.append(interface_load(package, table["at"], direction))
                labels.append(f"attachment {table['at']} {direction}")
        elif kind == "static-axial":
            loads.append(axial_load(package))
            labels.append(kind)
        elif kind == "static-inertia":
            loads += list(inertia_loads(package).T)
            labels += INERTIA_LABELS
        else:
            fits = [
                int(i)
                for i in rows
                if i not in kept
                and (kind == "lowest" or known[i].rpartition(" ")[0] in (kind, ALONG.get(kind)))
            ]
            if len(fits) < table["count"]:
                raise PackageError(
                    f"{package.body}: {table['count']} vibrations of kind {kind!r} asked for, the "
                    f"package has {len(fits)} more: {', '.join(known[i] for i in rows)}"
                )
            kept += fits[: table["count"]]
    P = np.column_stack(loads) if loads else np.zeros((package.n_mode, 0))
    return with_statics(package, sorted(kept), P, labels)
