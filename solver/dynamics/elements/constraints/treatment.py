"""Treatments of the constraints, their parameters, and the scaled constraint equations."""

from typing import Any

import numpy as np

from ....errors import did_you_mean
from ....math.arrays import Array
from ....math.records import record

IMPLICIT = ("ggl", "index3")  # solved within the step, by integrators that say so
# In the order of docs/constraints.md.
TREATMENTS = ("index1", "baumgarte", "augmented-lagrangian", "projection", *IMPLICIT)
# The others divide by a singular value that is zero there.
PASSES_SINGULAR = ("augmented-lagrangian", "projection", *IMPLICIT)


@record
class Treatment:
    """Name and parameters; those of other treatments have no effect.

    Raises ValueError : unknown name, with the nearest known one.
    """

    name: str = "projection"
    alpha: float = 5.0  # Baumgarte                            [1/s]
    beta: float = 5.0  # Baumgarte                             [1/s]
    penalty: float = 1e7  # augmented Lagrangian, relative to the effective mass of a row [-]
    frequency: float = 30.0  # augmented Lagrangian: W         [1/s]
    ratio: float = 1.0  # augmented Lagrangian: xi             [-]
    multiplier_tolerance: float = 1e-12  # of the iteration, relative
    multiplier_iterations: int = 20

    def __post_init__(self) -> None:
        if self.name not in TREATMENTS:
            raise ValueError(
                f"constraints: expected one of {', '.join(TREATMENTS)}, got {self.name!r}"
                f"{did_you_mean(self.name, TREATMENTS)}"
            )

    @classmethod
    def of(cls, solver: Any) -> "Treatment":
        """Return the treatment that `[solver]` of a case asks for, by keys of the same names."""
        keys = ("alpha", "beta", "penalty", "frequency", "ratio")
        return cls(solver.constraints, *(getattr(solver, key) for key in keys))


def row_masses(Phi_q: Array, inertia_scale: Array) -> Array:
    """Return the effective mass of each constraint row, (n_c,): 1 / sum_j Phi_ij^2 / scale_j.

    [kg] for a distance, [kg m2] for an angle; zero for a zero row.
    """
    mobility = (Phi_q * Phi_q) @ (1.0 / inertia_scale)
    masses = np.zeros(mobility.shape[0])
    np.divide(1.0, mobility, out=masses, where=mobility > 0.0)
    return masses


def scaled_jacobian(Phi_q: Array, inertia_scale: Array) -> Array:
    """Return C (n_c, n): rows of length one in the metric of the inertia.

    C = D Phi_q S^-1/2 with D^2 = `row_masses` and S = diag(inertia_scale): it does not depend on
    the units of rows and coordinates, so a singular value of 1e-8 has the same meaning everywhere.
    """
    root = np.sqrt(row_masses(Phi_q, inertia_scale))
    return root.reshape(-1, 1) * Phi_q / np.sqrt(inertia_scale)
