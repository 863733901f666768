"""A shell problem described in Python, solved by preprocess/shell, and what is read from it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plymotion.preprocess.laminate.stiffness import stress_operators
from plymotion.preprocess.shell.analyses.cases import Statics, solve_cases
from plymotion.preprocess.shell.analyses.frequencies import Frequencies, natural_modes
from plymotion.preprocess.shell.groups import group
from plymotion.preprocess.shell.model.shell_problem import ShellProblem

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
SCRIPTS = Path(__file__).resolve().parents[2] / "meshes" / "shells"
COMPONENTS = ("ux", "uy", "uz", "rx", "ry", "rz")


def isotropic(
    E: float, nu: float, h: float, rho: float = 1.0
) -> tuple[dict[str, Any], dict[str, Any]]:
    """A wall of one isotropic layer, and its material."""
    stack = laminate("metal", [0.0], h, "5/6")
    return stack, {"metal": {"kind": "isotropic", "E": E, "nu": nu, "rho": rho}}


def laminate(material: str, angles_deg: list[float], h: float, shear: Any) -> dict[str, Any]:
    """Plies of equal thickness, bottom to top, h [m] together."""
    thickness = h / len(angles_deg)
    plies = [
        {"material": material, "angle_deg": float(a), "thickness": thickness} for a in angles_deg
    ]
    return {"plies": plies, "shear_correction": shear}


@dataclass
class Model:
    """A specification as `preprocess shell` reads it; meshes are named by their script."""

    script: str
    mesh: dict[str, Any]
    materials: dict[str, Any]
    laminates: dict[str, Any]
    regions: dict[str, str]  # region -> laminate
    supports: dict[str, Any]
    loads: dict[str, Any] = field(default_factory=dict)
    frequencies: dict[str, Any] = field(default_factory=dict)
    axis: list[float] = field(default_factory=lambda: [1.0, 0.0, 0.0])

    def spec(
        self,
        elements: dict[str, Any] | None = None,
        mesh: dict[str, Any] | None = None,
        cells: dict[str, Any] | None = None,
    ) -> dict[str, Any]:
        """The specification, with other elements, more parameters or keys of the mesh."""
        return {
            "name": self.script,
            "mesh": {
                "file": str(SCRIPTS / f"{self.script}.py"),
                "parameters": {**self.mesh, **(mesh or {})},
                **(cells or {}),
            },
            "materials": self.materials,
            "laminates": self.laminates,
            "regions": {
                name: {"laminate": wall, "axis": self.axis} for name, wall in self.regions.items()
            },
            "elements": dict(elements or {}),
            "supports": self.supports,
            "loads": self.loads,
            **({"frequencies": self.frequencies} if self.frequencies else {}),
        }

    def solved(self, **options: Any) -> "Solved":
        """The problem, ready to be read; options as in `spec`."""
        return Solved(self.spec(**options))


class Solved:
    """Answers of one problem; what is not asked for is not computed."""

    def __init__(self, spec: dict[str, Any]) -> None:
        self.spec = spec
        self.problem = ShellProblem(spec, "benchmark")
        self.mesh, self.freedom = self.problem.mesh, self.problem.freedom

    @property
    def points_G(self) -> Array:
        """Nodes (n, 3) [m]."""
        return self.mesh.points_G

    @property
    def cells(self) -> IntArray:
        """Corners of the cells (c, 3)."""
        return self.mesh.cells

    @cached_property
    def forces(self) -> Array:
        """Nodal forces of every case, (n_dof, l)."""
        cases, loads = self.spec["loads"].items(), self.problem.loads
        return np.stack([loads.case(table, f"benchmark.{name}") for name, table in cases], axis=1)

    @cached_property
    def statics(self) -> Statics:
        """Displacements of every case."""
        return solve_cases(self.problem.K, self.freedom, self.forces, tuple(self.spec["loads"]))

    @cached_property
    def modes(self) -> Frequencies:
        """Natural modes, those of rigid motions first."""
        wanted, free_motions = self.spec["frequencies"], np.zeros((self.freedom.n_dof, 0))
        if wanted.get("free"):
            free_motions = np.stack(self.freedom.free_rigid_motions(), axis=1)
        return natural_modes(
            self.problem.K, self.problem.M, self.freedom, wanted["count"], free_motions
        )

    @property
    def frequencies(self) -> Array:
        """All natural frequencies found [Hz], those of rigid motions first."""
        return np.asarray(np.sqrt(np.abs(self.modes.values)) / (2.0 * np.pi))

    @property
    def elastic(self) -> Array:
        """Natural frequencies behind the rigid motions [Hz]."""
        return self.frequencies[self.modes.n_free_motions :]

    @property
    def shapes(self) -> Array:
        """Mode shapes at the nodes, (n, 6, m)."""
        return self.modes.shapes.reshape(-1, 6, self.modes.shapes.shape[1])

    def _case(self, case: str | None) -> int:
        return list(self.spec["loads"]).index(case) if case is not None else 0

    def probe(self, name: str, what: str, case: str | None = None) -> float:
        """Weighted mean of one component over a group."""
        of = group(self.mesh, name, "probe")
        u = self.statics.displacements[:, self._case(case)].reshape(-1, 6)
        return float(of.weights @ u[of.nodes, COMPONENTS.index(what)] / of.weights.sum())

    def work(self, case: str) -> float:
        """Displacement of a load along itself: force times displacement, summed."""
        row = self._case(case)
        return float(self.forces[:, row] @ self.statics.displacements[:, row])

    def cells_between(self, low: float, high: float) -> IntArray:
        """Cells whose middle lies between two values of x."""
        x = self.points_G[self.cells].mean(axis=1)[:, 0]
        return np.flatnonzero((x > low) & (x < high))

    def ply_stress(self, cells: IntArray) -> Array:
        """Stresses in ply axes of some cells, (cells, plies, levels, 6); a model of one region."""
        (region,) = self.problem.regions
        found = self.problem.resultants(self.statics.displacements)[0, cells]
        operators = stress_operators(region.laminate.laminate)
        return np.asarray(np.einsum("plij,cj->cpli", operators, found))


# A problem and how its numbers are read from the solution.
Problem = tuple[Model, Callable[[Any], Any]]
