"""A shell as a finite-element model: mesh, lay-ups, stiffness, mass and supports."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array
from .. import fenicsx
from .assembly import NO_LINES, NO_MATRICES, Assembly
from .errors import ShellError
from .flat_nodes import flat_nodes
from .freedom import Freedom
from .geometric import element_geometric, element_pressure
from .guards import drilling_motions, model_warnings
from .links import Link, read_links
from .loads import Loads
from .mass import element_mass
from .membranes import MEMBRANES
from .mesh import ShellMesh, shell_mesh
from .regions import Region, read_regions
from .resultants import element_resultants
from .section_link import section_rows
from .spec import check_spec, elements
from .stiffeners import read_stiffeners
from .stiffness import element_stiffness
from .straight_edges import with_straight_edges
from .supports import read_supports

AT_ONCE = 8  # number of states for which resultants are computed together


class ShellProblem:
    """The model of a shell, without its load cases and modes.

    Parameters
    ----------
    spec : see spec.py
    where : file and key of the specification, for messages
    team : processes that all make the same problem and share the work
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
        self.spec, self.where, self.team = spec, where, team
        self.choice, self.mass_form = elements(spec.get("elements", {}), f"{where}.elements")
        self.mesh = mesh or shell_mesh(spec["mesh"], f"{where}.mesh")
        self.regions = read_regions(spec, self.mesh, where)
        self.links = [
            self._with_rows(link)
            for link in read_links(spec.get("links", {}), self.mesh, f"{where}.links")
        ]
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

    @cached_property
    def modes_freedom(self) -> Freedom:
        """Degrees of freedom of natural modes and of buckling; `freedom` is that of load cases."""
        if all(support.only is None for support in self.supports):
            return self.freedom
        return self._freedom("modes")

    def _with_rows(self, link: Link) -> Link:
        if link.kind != "section":
            return link
        place = f"{self.where}.links.{link.name}.at"
        rows = section_rows(self.mesh, self.regions, link.group, link.point_G, place)
        return replace(link, rows=rows)

    def _freedom(self, purpose: str) -> Freedom:
        held = [support for support in self.supports if support.only in (None, purpose)]
        return Freedom(self.mesh, self.links, held, self.flat)

    @cached_property
    def K(self) -> sp.csr_matrix:
        """Stiffness of all degrees of freedom, (n_dof, n_dof) [N/m, N, N m]."""
        return self._assembled(
            lambda region, some: element_stiffness(
                region.geometry[some], region.stiffness, self.choice
            ),
            [stiffener.stiffness() for stiffener in self.stiffeners],
        )

    @cached_property
    def M(self) -> sp.csr_matrix:
        """Mass of all degrees of freedom, (n_dof, n_dof) [kg, kg m, kg m2]."""
        return self._assembled(
            lambda region, some: element_mass(
                region.geometry[some], region.stiffness.mass, self.mass_form
            ),
            [stiffener.mass(self.mass_form) for stiffener in self.stiffeners],
        )

    def geometric_stiffness(self, u: Array, in_plane: bool = True) -> sp.csr_matrix:
        """Geometric stiffness (n_dof, n_dof) [N/m] of the stresses of displacements u (n_dof,)."""
        N = self.resultants(u[:, None])[0, :, :3]
        return self._assembled(
            lambda region, some: element_geometric(
                region.geometry[some], N[region.cells[some]], in_plane
            ),
            [stiffener.geometric(u) for stiffener in self.stiffeners],
        )

    def pressure_stiffness(self, p: Array) -> sp.csr_matrix:
        """Stiffness (n_dof, n_dof) [N/m] of pressures that follow the surface, see `pressures`."""
        return self._assembled(
            lambda region, some: element_pressure(
                region.geometry[some], p[region.cells[some], : region.nodes.shape[1]]
            ),
            [np.zeros((len(s.ends), 12, 12)) for s in self.stiffeners],
        )

    @cached_property
    def loads(self) -> Loads:
        """Converter from descriptions of loads to nodal forces."""
        bow = MEMBRANES[self.choice.membrane].bow
        return Loads(self.freedom, self.regions, lambda: self.M, bow)

    def free_motions(self, freedom: Freedom) -> tuple[list[Array], list[Array]]:
        """Free rigid motions, and mechanisms of the drilling stiffness."""
        return freedom.free_rigid_motions(), drilling_motions(freedom, self.regions, self.choice)

    def resultants(self, u: Array) -> Array:
        """Resultants of every cell in E, (m, c, 8), of displacements (n_dof, m); cells have the
        order of the mesh."""
        nodes = u.reshape(len(u) // 6, 6, u.shape[1])
        out = np.empty((u.shape[1], len(self.mesh.cells), 8))
        for region in self.regions:
            for first in range(0, u.shape[1], AT_ONCE):  # no pass without states
                some = slice(first, first + AT_ONCE)
                corners = nodes[region.nodes][..., some]
                found = element_resultants(
                    region.geometry,
                    region.stiffness,
                    self.choice,
                    corners.reshape(len(region.cells), 6 * region.nodes.shape[1], -1),
                )
                out[some, region.cells] = np.moveaxis(found, 2, 0)
        return out

    @cached_property
    def _assembly(self) -> Assembly:
        lines = np.concatenate([NO_LINES, *(s.ends for s in self.stiffeners)])
        tables = [np.concatenate([r.nodes for r in kind]) for kind in self._kinds]
        return Assembly(tables, self.mesh.n_node, len(self.links), lines)

    def _assembled(
        self, element: Callable[[Region, slice], Array], lines: Sequence[Array]
    ) -> sp.csr_matrix:
        """Sum of the element matrices; each process of the team computes those of its cells.

        All processes sum them in the same order: for a thin shell, a difference in the last
        digit of the stiffness would change the ninth digit of its displacements.
        """
        found = [self._matrices(kind, element) for kind in self._kinds]
        return self._assembly.matrix(found, np.concatenate([NO_MATRICES, *lines]))

    @cached_property
    def _kinds(self) -> list[list[Region]]:
        """Regions of triangles, then those of quadrilaterals; no empty list."""
        kinds = [[r for r in self.regions if r.nodes.shape[1] == k] for k in (3, 4)]
        return [kind for kind in kinds if kind]

    def _matrices(
        self, regions: Sequence[Region], element: Callable[[Region, slice], Array]
    ) -> Array:
        """Element matrices of regions of one kind."""
        own = self.team.share(sum(len(region.cells) for region in regions))
        size = 6 * regions[0].nodes.shape[1]
        parts, first = [np.zeros((0, size, size))], 0
        for region in regions:
            count = len(region.cells)
            begin, end = (min(max(at - first, 0), count) for at in (own.start, own.stop))
            if begin < end:
                parts.append(element(region, slice(begin, end)))
            first += count
        return self.team.stacked(parts[1] if len(parts) == 2 else np.concatenate(parts))
