"""A shell as a finite-element model: mesh, lay-ups, stiffness, mass and supports.

Six unknowns per node, in the node numbering of the mesh; reference points of links come after the
nodes. Of several processes, each assembles the matrix of its own cells: the sum of all is that of
the shell.

The specification may be written by hand:

{"name": "panel", "mesh": {"file": "panel.msh"}, "materials": {...},
 "laminates": {"skin": {"plies": [{"material": "cfrp", "angle_deg": 45.0, "thickness": 1e-4}]}},
 "regions": {"all": {"laminate": "skin", "axis": [1.0, 0.0, 0.0]}},
 "elements": {"plate": "dkmt", "membrane": "opt", "mass_form": "consistent"},
 "stiffeners": {"rib": {"at": "ridge", "section": {...}, "offset": [0.0, 0.01]}},
 "links": {"end": {"at": "tip", "kind": "rigid"}},
 "supports": {"root": {"at": "root", "fixed": "all"}},
 "loads": {"pull": {"tip": {"at": "end", "force": [1.0, 0.0, 0.0]}}},
 "probes": {"tip": {"at": "end", "what": "uz"}},
 "frequencies": {"count": 6, "free": false, "prestress": "pull", "error": true},
 "buckling": {"count": 4, "cases": ["pull"], "constant": "weight", "in_plane": true,
              "error": true},
 "bound": "frequency", "bound_angles_deg": [0.0, 45.0, -45.0, 90.0]}

SI and degrees; docs/shell-description.md explains each key.
"""

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy.sparse as sp

from ....solver.errors import check_keys, check_known
from ....solver.math.arrays import Array
from ....solver.package.body.package_schema import MASS_FORMS
from ... import fenicsx
from ..elements.membranes import MEMBRANES
from ..elements.pairs import (
    Choice,
    geometric_kernel,
    mass_kernel,
    pressure_kernel,
    stiffness_kernel,
)
from ..elements.single_cells import cell_table, element_resultants, write
from ..shell_cells import ShellError, ShellMesh
from ..shell_mesh import KEYS as MESH
from ..shell_mesh import shell_mesh
from .freedom import Freedom, flat_nodes
from .links import read_links
from .loads import KEYS as LOAD
from .loads import Loads
from .regions import Region, own_cells, read_regions, relaid
from .shell_warnings import drilling_motions, model_warnings
from .stiffeners import KEYS as STIFFENER
from .stiffeners import CellsBeside, read_stiffeners
from .supports import read_supports, with_straight_edges

REQUIRED = ("mesh", "materials", "regions")
TABLES = (
    "laminates",
    "elements",
    "stiffeners",
    "links",
    "supports",
    "loads",
    "probes",
    "frequencies",
    "buckling",
)
OTHER = ("name", "title", "format", "allow", "bound", "bound_angles_deg")
REGION = (
    *("laminate", "material", "thickness", "offset", "shear_correction"),
    *("axis", "axis_curve", "axis_about", "flip"),
)
ENTRIES = {
    "regions": REGION,
    "stiffeners": STIFFENER,
    "links": ("at", "kind", "point"),
    "supports": ("at", "fixed", "only"),
    "probes": ("at", "near", "what"),
}


BUCKLING = ("count", "cases", "constant", "in_plane", "error")


def check_spec(spec: Mapping[str, Any], where: str) -> None:
    """Raise ShellError for a key that is unknown, missing or not a table."""
    check_keys(spec, (*REQUIRED, *TABLES, *OTHER), where, ShellError)
    for key in REQUIRED:
        if not isinstance(spec.get(key), Mapping) or not spec[key]:
            raise ShellError(f"{where}.{key} = {spec.get(key)!r}: expected a table")
    for key in TABLES:
        if key in spec and not isinstance(spec[key], Mapping):
            raise ShellError(f"{where}.{key} = {spec[key]!r}: expected a table")
    check_keys(spec["mesh"], MESH, f"{where}.mesh", ShellError)
    for key, known in ENTRIES.items():
        for name, entry in spec.get(key, {}).items():
            check_keys(entry, known, f"{where}.{key}.{name}", ShellError)
    for case, loads in spec.get("loads", {}).items():
        if not isinstance(loads, Mapping):
            raise ShellError(f"{where}.loads.{case} = {loads!r}: expected a table of loads")
        for name, entry in loads.items():
            check_keys(entry, LOAD, f"{where}.loads.{case}.{name}", ShellError)
    modes = ("count", "free", "prestress", "error")
    check_keys(spec.get("frequencies", {}), modes, f"{where}.frequencies", ShellError)
    check_keys(spec.get("buckling", {}), BUCKLING, f"{where}.buckling", ShellError)


def elements(table: Mapping[str, Any], where: str) -> tuple[Choice, str]:
    """Elements and form of the mass. Raises ShellError for a name that does not exist."""
    check_keys(table, (*Choice._fields, "mass_form"), where, ShellError)
    form = table.get("mass_form", "consistent")
    check_known(form, MASS_FORMS, f"{where}.mass_form", ShellError)
    given = {key: table[key] for key in Choice._fields if key in table}
    try:
        return Choice(**given).checked(), form
    except ShellError as error:
        raise ShellError(f"{where}.{error}") from error


def mode_count(table: Mapping[str, Any], where: str, default: int = 6) -> int:
    """Number of requested modes.

    Parameters
    ----------
    table : of the specification, with `count`
    where : key of the table, for messages
    default : without this key

    Raises
    ------
    ShellError
        No whole number above 0.
    """
    count = table.get("count", default)
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise ShellError(f"{where}.count = {count!r}: expected a whole number above 0")
    return count


# Lay-ups of one mesh, one after the other, share what DOLFINx needs of it and of its finer one.
@lru_cache(maxsize=4)
def _surface(mesh: ShellMesh, nodes: bytes, corners: int) -> fenicsx.Surface:
    """Cells of one kind by their nodes."""
    cells = np.frombuffer(nodes, dtype=np.int64).reshape(-1, corners)
    return fenicsx.Surface(mesh.points_G, cells)


@lru_cache(maxsize=4)
def _pattern(surfaces: tuple[fenicsx.Surface, ...], n_node: int) -> fenicsx.SurfacePattern:
    return fenicsx.SurfacePattern([surface.cells for surface in surfaces], n_node)


AT_ONCE = 16  # number of states for which resultants are computed together


class ShellProblem:
    """The model of a shell, without its load cases and modes.

    Parameters
    ----------
    spec : see above
    where : file and key of the specification, for messages
    team : processes that all make the same problem and share its matrices: each has its part of
        their sum
    mesh : replaces the mesh that the specification names

    Raises
    ------
    ShellError, LaminateError, MaterialError : the specification is wrong.
    """

    def __init__(
        self,
        spec: Mapping[str, Any],
        where: str = "shell",
        team: fenicsx.Team = fenicsx.ALONE,
        mesh: ShellMesh | None = None,
    ) -> None:
        check_spec(spec, where)
        self.spec, self.where = spec, where
        self.choice, self.mass_form = elements(spec.get("elements", {}), f"{where}.elements")
        self.mesh = mesh or shell_mesh(spec["mesh"], f"{where}.mesh")
        self.regions = read_regions(spec, self.mesh, where)
        self.team = team if len(self.mesh.cells) >= team.size else fenicsx.ALONE
        self.own = own_cells(self.regions, self.mesh, self.team)
        self.links = read_links(spec.get("links", {}), self.mesh, self.regions, f"{where}.links")
        self.supports = read_supports(
            spec.get("supports", {}), self.mesh, self.links, f"{where}.supports"
        )
        self.stiffeners = read_stiffeners(
            spec.get("stiffeners", {}), self.mesh, self.regions, f"{where}.stiffeners"
        )
        membrane = MEMBRANES[self.choice.membrane]
        if membrane.rotations:
            self.supports = with_straight_edges(self.supports, self.mesh)
        plain = not membrane.rotations and self.choice.drilling_form() == "none"
        if self.mesh.cells.shape[1] == 4 and not membrane.rotations:
            raise ShellError(
                f"{where}.elements.membrane = {self.choice.membrane!r}: a mesh with quadrilaterals "
                "needs a membrane with rotations, "
                + " or ".join(name for name, m in MEMBRANES.items() if m.rotations)
            )
        self.flat = flat_nodes(self.mesh, self.regions, self.stiffeners) if plain else None
        self.freedom = self._freedom("loads")
        self.warnings = model_warnings(self.mesh, self.regions, self.links, self.choice)

    def relaid(self, spec: Mapping[str, Any]) -> "ShellProblem":
        """The same shell with other numbers of its laminates, materials and stiffeners."""
        if self.stiffeners or any(link.kind == "section" for link in self.links):
            return ShellProblem(spec, self.where, mesh=self.mesh)
        other = copy.copy(self)
        for name in ("K", "M", "loads"):
            vars(other).pop(name, None)
        other.spec = spec
        other.regions = other.own = relaid(self.regions, spec, self.where)
        regions = zip(self.regions, other.regions, strict=True)
        if all(np.array_equal(a.stiffness.mass, b.stiffness.mass) for a, b in regions):
            other.M = self.M
        return other

    @property
    def laminates(self) -> dict[str, Region]:
        """A region of each laminate that is used, by the name of the laminate."""
        return {region.laminate_name: region for region in self.regions}

    @cached_property
    def modes_freedom(self) -> Freedom:
        """Degrees of freedom of natural modes and of buckling; `freedom` is that of load cases."""
        if all(support.only is None for support in self.supports):
            return self.freedom
        return self._freedom("modes")

    def _freedom(self, purpose: str) -> Freedom:
        held = [support for support in self.supports if support.only in (None, purpose)]
        return Freedom(self.mesh, self.links, held, self.flat)

    @cached_property
    def K(self) -> sp.csr_matrix:
        """Stiffness of all degrees of freedom, (n_dof, n_dof) [N/m, N, N m]."""
        K = self._assembled(lambda k: stiffness_kernel(k, self.choice))
        if self.beside is not None:
            K = K + self.beside.stiffness(self.choice)
        return self._with_lines(K, [stiffener.stiffness() for stiffener in self.stiffeners])

    def stiffness_of(self, ABDs: Sequence[Array], choice: Choice) -> sp.csr_matrix:
        """Stiffness of all degrees of freedom with the same A, B, D, Ds in all cells."""
        A, B, D, Ds = ABDs
        cells = [
            replace(region, stiffness=region.stiffness._replace(A=A, B=B, D=D, Ds=Ds))
            for region in self.own
        ]
        return self._assembled(lambda k: stiffness_kernel(k, choice), cells, choice)

    @cached_property
    def beside(self) -> CellsBeside | None:
        """Cells of this process at stiffeners, None without any."""
        if not self.stiffeners:
            return None
        ends = np.concatenate([stiffener.ends for stiffener in self.stiffeners])
        return CellsBeside(self.mesh, self.regions, self.own, ends, self.freedom.n_dof)

    @cached_property
    def M(self) -> sp.csr_matrix:
        """Mass of all degrees of freedom, (n_dof, n_dof) [kg, kg m, kg m2]."""
        return self._with_lines(
            self._assembled(lambda k: mass_kernel(k, self.mass_form)),
            [stiffener.mass(self.mass_form) for stiffener in self.stiffeners],
        )

    def geometric_stiffness(self, u: Array, in_plane: bool = True) -> sp.csr_matrix:
        """Geometric stiffness (n_dof, n_dof) [N/m] of the stresses of displacements u (n_dof,)."""
        N = self.resultants(u[:, None])[0, :, :3]
        on_turns = np.full(len(N), float(in_plane))
        return self._with_lines(
            self._assembled(geometric_kernel, N=N, in_plane=on_turns),
            [stiffener.geometric(u) for stiffener in self.stiffeners],
        )

    def pressure_stiffness(self, p: Array) -> sp.csr_matrix:
        """Stiffness (n_dof, n_dof) [N/m] of pressures that follow the surface, see `pressures`."""
        p = np.pad(p, ((0, 0), (0, 4 - p.shape[1])))
        return self._assembled(pressure_kernel, p=p)

    @cached_property
    def loads(self) -> Loads:
        """Converter from descriptions of loads to nodal forces."""
        bow = MEMBRANES[self.choice.membrane].bow
        return Loads(self.freedom, self.regions, lambda u: self.team.total(self.M @ u), bow)

    def free_motions(self, freedom: Freedom) -> tuple[list[Array], list[Array]]:
        """Free rigid motions, and mechanisms of the drilling stiffness."""
        return freedom.free_rigid_motions(), drilling_motions(freedom, self.regions, self.choice)

    def resultants(self, u: Array) -> Array:
        """Resultants of every cell in E, (m, c, 8), of displacements (n_dof, m); cells have the
        order of the mesh."""
        nodes = u.reshape(len(u) // 6, 6, u.shape[1])
        out = np.zeros((u.shape[1], len(self.mesh.cells), 8))
        for number, region in enumerate(self.own):
            for first in range(0, u.shape[1], AT_ONCE):  # no pass without states
                some = slice(first, first + AT_ONCE)
                corners = nodes[region.nodes][..., some]
                corners = corners.reshape(len(region.cells), 6 * region.nodes.shape[1], -1)
                if self.beside is not None:
                    corners = self.beside.moved(number, corners, u[:, some])
                values = element_resultants(region.geometry, region.stiffness, self.choice, corners)
                out[some, region.cells] = np.moveaxis(values, 2, 0)
        return self.team.total(out)

    def _assembled(
        self,
        kernel: Callable[[int], fenicsx.Kernel],
        regions: Sequence[Region] | None = None,
        choice: Choice | None = None,
        **entries: Array,
    ) -> sp.csr_matrix:
        """Sum of the matrices of the cells, (n_dof, n_dof) with ascending columns.

        Parameters
        ----------
        kernel : of cells with a number of corners (pairs.py)
        regions, choice : with other laminates and elements than those of the shell
        entries : of the table of the cells by their names, in the order of the mesh
        """
        by_corners = ([r for r in regions or self.own if r.nodes.shape[1] == k] for k in (3, 4))
        kinds = [kind for kind in by_corners if kind]
        # first, because what DOLFINx needs a compiler for gives a worse message without one
        kernels = [kernel(kind[0].nodes.shape[1]) for kind in kinds]
        parts = []
        for kind, kernel_of_kind in zip(kinds, kernels, strict=True):
            nodes = np.concatenate([region.nodes for region in kind]).astype(np.int64)
            cells = np.concatenate([region.cells for region in kind])
            data = [cell_table(r.geometry, r.stiffness, choice or self.choice) for r in kind]
            table = np.concatenate(data)
            write(table, **{name: values[cells] for name, values in entries.items()})
            surface = _surface(self.mesh, nodes.tobytes(), nodes.shape[1])
            parts.append((surface, kernel_of_kind, table))
        surfaces = tuple(surface for surface, _, _ in parts)
        return _pattern(surfaces, self.mesh.n_node + len(self.links)).summed(parts)

    def _with_lines(self, matrix: sp.csr_matrix, lines: Sequence[sp.csr_matrix]) -> sp.csr_matrix:
        """Add the matrices of the beams that stiffen the shell."""
        for line in () if self.team.rank else lines:  # of several processes, the first has them
            line.resize(matrix.shape)
            matrix = matrix + line
        return matrix
