"""A modal package as standard input data (SID, Wallrapp 1994) of a flexible body: .SID_FEM.

Checked against the text of the format, without a run of a program that reads it. Every matrix is a
Taylor series in the modal coordinates, m0 + m1 q; an entry of m1 counts row, mode, column.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ....solver.errors import printable
from ....solver.math.arrays import Array
from ....solver.math.rotations import skew
from ....solver.package import ModalPackage
from ....solver.package.body.invariants import free_body_mass, inertia_at_rest
from ....solver.package.common.files import write_text

SUFFIX = ".SID_FEM"
ZERO, FULL = 0, 3  # values of `structure`
NONE = np.zeros((0, 0, 0))
a, b, c = np.ogrid[:3, :3, :3]
EPS = (a - b) * (b - c) * (c - a) / 2.0


def write(package: ModalPackage, out: Path, source: Path) -> str:
    """Write the modes, a node per interface, and the inertia integrals.

    Parameters
    ----------
    package, out, source : see contract.py
    """
    write_text(out, "\n".join(_lines(package)) + "\n", encoding="ascii")
    count = len(package.interfaces)
    return f"{package.n_mode} modes, {count} nodes; no program was run with it"


def _lines(package: ModalPackage) -> Iterator[str]:
    m, mass = package.n_mode, package.invariants.mass
    title = printable(package.body)[:60]
    yield f"{len(package.interfaces):5d} {m:3d}    :No. nodes, No. modes: {title}"
    yield " part"
    yield "      new modal                                 ="
    yield "           refmod"
    yield _entry("mass", _number(mass), 16)
    yield _entry("nelastq", f"{m:6d}", 16)
    labels = package.mode_labels or package.mode_kinds
    for i, (label, w) in enumerate(zip(labels, package.frequencies, strict=True), 1):
        text = f" Mode {i:4d} {printable(label)[:30]} : {w / (2.0 * np.pi):12.3f} Hz"
        yield _entry(f"ielastq ({i:4d})", text, 16)
    yield "           end refmod"
    yield "           frame"
    for number in range(len(package.interfaces)):
        yield from _node(package, number)
    yield "           end frame"
    for name, (m0, m1) in integrals(package).items():
        yield f"           {name}"
        yield from _taylor(m0, m1, m)
        yield f"           end {name}"
    yield "      end modal"
    yield " end part"


def _node(package: ModalPackage, number: int) -> Iterator[str]:
    """Place, shapes and axes of an interface."""
    interface, m = package.interfaces[number], package.n_mode
    yield f"                new node                        = {number + 1:6d}"
    yield "                     rframe                     =    body ref"
    turned = np.array([skew(psi) @ interface.A_BI for psi in interface.psi_B.T]).reshape(m, 3, 3)
    parts = {
        "origin": (interface.position_B[:, None], interface.phi_B[:, :, None]),
        "phi": (interface.phi_B, NONE),
        "psi": (interface.psi_B, NONE),
        "AP": (interface.A_BI, np.moveaxis(turned, 0, 1)),
    }
    for name, (m0, m1) in parts.items():
        yield f"                     {name}"
        yield from _taylor(m0, m1, m)
        yield f"                     end {name}"
    yield "                end node"


def integrals(package: ModalPackage) -> dict[str, tuple[Array, Array]]:
    """m0 (rows, columns) and m1 (rows, m, columns), of order 0 empty, by name.

    J has the rows xx, yy, zz, xy, xz, yz; Gr and Ge three columns per mode; Oe multiplies
    w_x^2, w_y^2, w_z^2, w_x w_y, w_y w_z, w_x w_z.
    """
    inv, m = package.invariants, package.n_mode
    T01, T11 = inv.T01_B, inv.T11_B
    trace, one = np.einsum("aai->i", T01), np.eye(3)
    J1 = 2.0 * trace * one[:, :, None] - T01 - np.swapaxes(T01, 0, 1)
    Gr = 2.0 * (trace * one[:, :, None] - np.swapaxes(T01, 0, 1))
    # [l, k, a]: component a of the integral of phi_k x phi_l
    across = np.einsum("abc,bckl->lka", EPS, T11)
    # Quadratic forms of w in phi_l . w x (w x r): rows and columns of w.
    still = np.swapaxes(T01, 0, 1) - trace * one[:, :, None]
    moved = T11 - np.einsum("ccij->ij", T11) * one[:, :, None, None]
    angular = free_body_mass(package)[3:6, 6:]
    return {
        "mdCM": (inv.S0_B[:, None], inv.S_B[:, :, None]),
        "J": (_six(inertia_at_rest(inv))[:, None], _six(J1)[:, :, None]),
        "Ct": (inv.S_B.T, NONE),
        "Cr": (angular.T, across),
        "Me": (package.mass, NONE),
        "Gr": (np.moveaxis(Gr, 2, 1).reshape(3, 3 * m), NONE),
        "Ge": (2.0 * across.reshape(m, 3 * m), NONE),
        "Oe": (_products(still).T, np.moveaxis(_products(moved), 0, 2)),
        "ksigma": (np.zeros((m, 1)), NONE),
        "Ke": (package.stiffness, NONE),
        "De": (package.damping, NONE),
    }


def _six(A: Array) -> Array:
    """Entries xx, yy, zz, xy, xz, yz of symmetric tensors (3, 3, ...)."""
    return np.stack([A[0, 0], A[1, 1], A[2, 2], A[0, 1], A[0, 2], A[1, 2]])


def _products(A: Array) -> Array:
    """Coefficients of xx, yy, zz, xy, yz, xz in quadratic forms (3, 3, ...)."""
    pairs = [(0, 1), (1, 2), (0, 2)]
    return np.stack([*(A[k, k] for k in range(3)), *(A[i, j] + A[j, i] for i, j in pairs)])


def _taylor(m0: Array, m1: Array, modes: int) -> Iterator[str]:
    """One Taylor series; entries that are zero are left out."""
    order, some = int(m1.size > 0), bool(m0.any() or m1.any())
    head = {"order": order, "nrow": m0.shape[0], "ncol": m0.shape[1], "nq": modes, "nqn": 0}
    for key, value in {**head, "structure": FULL if some else ZERO}.items():
        yield _entry(key, f"{value:5d}")
    for i, j in np.argwhere(m0):
        yield _entry(f"m0({i + 1:2d},{j + 1:2d})", _number(m0[i, j]))
    for i, j, k in np.argwhere(np.moveaxis(m1, 2, 0)):
        place = f"m1({j + 1:2d},{k + 1:2d},{i + 1:2d})"
        yield _entry(place, _number(m1[j, k, i]))


def _entry(key: str, value: str, indent: int = 26) -> str:
    return f"{' ' * indent}{key}".ljust(48) + "=" + value


def _number(value: float) -> str:
    return f"{value:18.11E}".replace("E", "D")
