"""A shell as a finite-element model: mesh, lay-ups, stiffness, mass and supports."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array
from ... import fenicsx
from ..elements.membranes import MEMBRANES
from ..elements.pairs import geometric_kernel, mass_kernel, pressure_kernel, stiffness_kernel
from ..elements.resultants import element_resultants
from ..errors import ShellError
from ..mesh.mesh import ShellMesh, shell_mesh
from .assembly import Assembly
from .freedom import Freedom, flat_nodes
from .guards import drilling_motions, model_warnings
from .links import Link, read_links
from .loads import Loads
from .regions import own_cells, read_regions
from .section_link import section_rows
from .spec import check_spec, elements
from .stiffeners import read_stiffeners
from .supports import read_supports, with_straight_edges

AT_ONCE = 8  # number of states for which resultants are computed together


class ShellProblem:
    """The model of a shell, without its load cases and modes.

    Parameters
    ----------
    spec : see spec.py
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
        self._own = own_cells(self.regions, self.mesh, self.team)
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
        return self._with_lines(
            self._assembly.matrix(lambda k: stiffness_kernel(k, self.choice)),
            [stiffener.stiffness() for stiffener in self.stiffeners],
        )

    @cached_property
    def M(self) -> sp.csr_matrix:
        """Mass of all degrees of freedom, (n_dof, n_dof) [kg, kg m, kg m2]."""
        return self._with_lines(
            self._assembly.matrix(lambda k: mass_kernel(k, self.mass_form)),
            [stiffener.mass(self.mass_form) for stiffener in self.stiffeners],
        )

    def geometric_stiffness(self, u: Array, in_plane: bool = True) -> sp.csr_matrix:
        """Geometric stiffness (n_dof, n_dof) [N/m] of the stresses of displacements u (n_dof,)."""
        N = self.resultants(u[:, None])[0, :, :3]
        on_turns = np.full(len(N), float(in_plane))
        return self._with_lines(
            self._assembly.matrix(geometric_kernel, N=N, in_plane=on_turns),
            [stiffener.geometric(u) for stiffener in self.stiffeners],
        )

    def pressure_stiffness(self, p: Array) -> sp.csr_matrix:
        """Stiffness (n_dof, n_dof) [N/m] of pressures that follow the surface, see `pressures`."""
        p = np.pad(p, ((0, 0), (0, 4 - p.shape[1])))
        return self._assembly.matrix(pressure_kernel, p=p)

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
        for region in self._own:
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
        return self.team.total(out)

    @cached_property
    def _assembly(self) -> Assembly:
        return Assembly(self.mesh, self._own, self.choice, len(self.links))

    def _with_lines(self, matrix: sp.csr_matrix, lines: Sequence[Array]) -> sp.csr_matrix:
        """Add the matrices of the beams that stiffen the shell."""
        if not lines or self.team.rank:  # of several processes, the first has the beams
            return matrix
        ends = np.concatenate([stiffener.ends for stiffener in self.stiffeners])
        return matrix + self._assembly.lines(ends, np.concatenate(lines))
