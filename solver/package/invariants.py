"""Inertia invariants of a reduced flexible body. Paper: Eq. (2), Eq. (15)."""

import numpy as np

from .schema import Array, Invariants


def from_stations(
    m: Array, x_B: Array, phi_B: Array, psi_B: Array, J_B: Array, mass_form: str
) -> Invariants:
    """Sum mass stations into the invariants that the solver needs.

    The paper sums over nodes with lumped masses (`mass_form="lumped"`). Taking
    the integration points of the consistent mass matrix as stations gives the
    consistent invariants from the same sums.

    Parameters
    ----------
    m : (k,) station masses [kg]
    x_B : (k, 3) rest positions of the stations' mass centres [m]
    phi_B : (k, 3, n_mode) translation of the mass centre per unit mode [m]
    psi_B : (k, 3, n_mode) rotation per unit mode [rad]
    J_B : (k, 3, 3) rotary inertia about the mass centre [kg m2]
    mass_form : "consistent" or "lumped"
    """
    return Invariants(
        mass=float(m.sum()),
        S0_B=np.einsum("k,ka->a", m, x_B),
        S_B=np.einsum("k,kai->ai", m, phi_B),
        T00_B=np.einsum("k,ka,kb->ab", m, x_B, x_B),
        T01_B=np.einsum("k,ka,kbi->abi", m, x_B, phi_B, optimize=True),
        T11_B=np.einsum("k,kai,kbj->abij", m, phi_B, phi_B, optimize=True),
        J0_B=J_B.sum(axis=0),
        J_psi_B=np.einsum("kab,kbi->ai", J_B, psi_B, optimize=True),
        mass_form=mass_form,
    )


def inertia_at_rest(invariants: Invariants) -> Array:
    """Inertia tensor of the undeformed body about the frame origin, (3, 3) [kg m2]."""
    T = invariants.T00_B
    return np.trace(T) * np.eye(3) - T + invariants.J0_B
