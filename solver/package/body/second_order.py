"""Second-order displacements of the modes, and their effect on the inertia of a body.

To second order a mass station moves with the modes to x + phi q + 1/2 q' h q. A bent beam
shortens, which the linear shapes neglect. This is equivalent to the geometric stiffness: for any
load f, sum f_k h_ij,k = -X_i' K_geo(f) X_j with the stresses of f (docs/stiffening.md).
"""

import numpy as np

from ...math.arrays import Array
from ...math.definite import is_positive_definite
from ..common.array_checks import ROUNDING, SYMMETRY, finite, positive_definite
from ..common.dataset import DatasetSpec, F, spec
from ..common.remark import Reporter
from .scales import body_size, second_order_sizes
from .schema import Interface, ModalPackage, SecondOrder

MOST_MODES = 40  # G4 has m^4 numbers; bodies with more modes have no second-order data

SECOND_ORDER_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("second_order/Z0_B", "3, m, m", F, "kg m", "B", "sum m h_a,ij"),
    spec("second_order/Z1_B", "3, 3, m, m", F, "kg m2", "B", "sum m x_a h_b,ij"),
    spec("second_order/G3", "m, m, m", F, "kg m2", "-", "sum m phi_i . h_jk"),
    spec("second_order/G4", "m, m, m, m", F, "kg m2", "-", "sum m h_ij . h_kl"),
)
INTERFACE_SECOND_ORDER_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("H_B", "3, m, m", F, "m", "B", "second-order translation of the interface"),
    spec("H_psi_B", "3, m, m", F, "rad", "B", "second-order rotation vector of the interface"),
)


def second_order_from_stations(m: Array, x_B: Array, phi_B: Array, h_B: Array) -> SecondOrder:
    """Sum mass stations into the second-order invariants.

    Parameters
    ----------
    m, x_B, phi_B : as in `from_stations`, of the same stations
    h_B : (k, 3, n_mode, n_mode) second-order translation of the mass centres [m]
    """
    n = phi_B.shape[2]
    weighted = m[:, None, None, None] * h_B
    flat = h_B.reshape(-1, n * n)
    G4 = weighted.reshape(-1, n * n).T @ flat
    return SecondOrder(
        Z0_B=weighted.sum(axis=0),
        Z1_B=np.einsum("ka,kbij->abij", x_B, weighted, optimize=True),
        G3=(phi_B.reshape(-1, n).T @ weighted.reshape(-1, n * n)).reshape(n, n, n),
        G4=(0.5 * (G4 + G4.T)).reshape(n, n, n, n),
    )


def second_order_values(second: SecondOrder) -> dict[str, Array]:
    """Return the value of every dataset of SECOND_ORDER_LAYOUT by path."""
    return {s.path: getattr(second, s.path.split("/")[1]) for s in SECOND_ORDER_LAYOUT}


def modal_mass_at(package: ModalPackage, q: Array) -> Array:
    """Modal mass of the body deformed by q (m,), (m, m): a sum over stations, so never negative."""
    second = package.second_order
    if second is None:
        return package.mass
    linear = second.G3 @ q
    bent = np.tensordot(second.G4 @ q, q, axes=(1, 0))  # G4[i, k, j, l] q[k] q[l]
    return np.asarray(package.mass + linear + linear.T + bent)


def check_second_order(package: ModalPackage, error: Reporter) -> None:
    """Report second-order data that the solver cannot use."""
    second = package.second_order
    if second is None:
        for interface in package.interfaces:
            if interface.H_B is not None:
                where = f"interfaces/{interface.name}/H_B"
                error(where, "needs the group second_order, which the body does not have")
        return
    tables = list(second_order_values(second).items())
    for interface in package.interfaces:
        tables += _of_interface(interface, error)
    sizes = second_order_sizes(package)
    sound = True
    for path, value in tables:
        before = _Count(error)
        finite(path, value, before)
        if not before.count:
            _symmetric_modes(path, value, sizes[path.rpartition("/")[2]], before)
        sound = sound and not before.count
    if sound and package.n_mode:
        _exchange(second.G4, sizes["G4"], error)
        _definite(package, error)


def _of_interface(interface: Interface, error: Reporter) -> list[tuple[str, Array]]:
    found = []
    for name in ("H_B", "H_psi_B"):
        value = getattr(interface, name)
        path = f"interfaces/{interface.name}/{name}"
        if value is None:
            error(path, "missing: a body with second_order needs it at every interface")
        else:
            found.append((path, value))
    return found


class _Count:
    """A reporter that counts its calls."""

    def __init__(self, error: Reporter) -> None:
        self.count, self._error = 0, error

    def __call__(self, dataset: str, message: str) -> None:
        self.count += 1
        self._error(dataset, message)


def _symmetric_modes(path: str, value: Array, size: float, error: Reporter) -> None:
    """Report a table that changes if its last two modes are exchanged.

    `size` is that of the terms of its sums, because the terms may cancel: in a mean-axis frame Z0_B
    is round-off.
    """
    if not value.size:
        return
    gap = np.abs(value - np.swapaxes(value, -1, -2))
    if gap.max() > max(SYMMETRY * np.abs(value).max(), ROUNDING * size):
        i, j = (int(k) for k in np.unravel_index(np.argmax(gap), gap.shape)[-2:])
        error(
            path,
            f"expected symmetry in its last two modes, [{i}, {j}] and [{j}, {i}] differ by "
            f"{gap.max():.3g}",
        )


def _exchange(G4: Array, size: float, error: Reporter) -> None:
    """Report a G4 that changes if its two pairs of modes are exchanged."""
    gap = np.abs(G4 - G4.transpose(2, 3, 0, 1)).max()
    if gap > max(SYMMETRY * np.abs(G4).max(), ROUNDING * size):
        error("second_order/G4", f"expected [i, j, k, l] = [k, l, i, j], they differ by {gap:.3g}")


def _definite(package: ModalPackage, error: Reporter) -> None:
    """Report a modal mass that is not positive definite in a deformed body.

    Checks each mode and some combinations, with amplitudes that rotate an interface by a tenth of a
    radian or move it by a tenth of the size of the body.
    """
    m = package.n_mode
    if not is_positive_definite(package.mass):
        return  # reported for modes/mass
    size = body_size(package)
    for direction in (*np.eye(m), *np.random.default_rng(0).normal(size=(4, m))):
        motion = [np.linalg.norm(i.phi_B @ direction) / size for i in package.interfaces]
        motion += [np.linalg.norm(i.psi_B @ direction) for i in package.interfaces]
        largest = float(max(motion, default=0.0))
        if largest == 0.0:
            continue
        for q in (0.1 / largest * direction, -0.1 / largest * direction):
            seen = _Count(error)
            positive_definite("second_order/G4", modal_mass_at(package, q), seen)
            if seen.count:
                return
