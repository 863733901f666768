"""Load cases: work-equivalent nodal forces of the described loads.

[loads.CASE.NAME]
at = "tip"                     physical point, curve or surface, or a link
force = [x, y, z]              total [N], distributed by length, area, or equally over points
moment = [x, y, z]             total [N m], distributed in the same way
force_per_length = [x, y, z]   on a curve [N/m]
force_per_area = [x, y, z]     on a surface, or everywhere without `at` [N/m2]
pressure = p                   along +e3 of each cell [N/m2]
sine = [a, b, c]               factor sin(pi x/a) sin(pi y/b) sin(pi z/c) of the last two; a
                               length of 0 omits its factor
gravity = [x, y, z]            acceleration of the whole shell [m/s2], without `at`
motion = {"uz": 1e-3}          displacement [m] or rotation [rad] of components that a support holds
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ....solver.errors import did_you_mean
from ....solver.math.arrays import Array, IntArray
from ..groups import group, vector
from ..shell_cells import DOFS, ShellError, ShellMesh
from .freedom import Freedom
from .regions import Region, cell_axes
from .supports import COMPONENTS

KINDS = ("force", "moment", "force_per_length", "force_per_area", "pressure", "gravity")
KEYS = ("at", *KINDS, "sine", "motion")
ON_CELLS = ("force_per_area", "pressure")


class Loads:
    """Converts descriptions of loads to nodal forces of a shell.

    Parameters
    ----------
    regions : all of the mesh, for areas and normals
    mass : gives the product of the mass matrix and a motion (n_dof,)
    bow : of the membrane's sides (membranes/contract.py)
    """

    def __init__(
        self,
        freedom: Freedom,
        regions: Sequence[Region],
        mass: Callable[[Array], Array],
        bow: float = 0.0,
    ) -> None:
        self.freedom, self.mesh = freedom, freedom.mesh
        self.regions, self._mass, self._bow = regions, mass, bow

    def case(self, table: Mapping[str, Any], where: str) -> Array:
        """Forces and moments on all degrees of freedom, (n_dof,) [N, N m].

        Raises ShellError for a table without load, a group of the wrong kind, or a wrong number.
        """
        forces = np.zeros((self.freedom.n_dof // DOFS, DOFS))
        for name, entry in table.items():
            self._add(forces, entry, f"{where}.{name}")
        return forces.ravel()

    def pressures(self, table: Mapping[str, Any], where: str) -> Array:
        """Pressure of a load case at the integration points of all cells, (c, 3|4) [N/m2]."""
        out = np.zeros(self.mesh.cells.shape)
        for name, entry in table.items():
            if entry.get("pressure") is None:
                continue
            for region in self._chosen("pressure", entry.get("at"), f"{where}.{name}"):
                intensity = self._intensity(entry, region, f"{where}.{name}")
                out[region.cells, : intensity.shape[1]] += float(entry["pressure"]) * intensity
        return out

    def columns(self, cases: Mapping[str, Any], where: str) -> tuple[Array, Array]:
        """Forces and given displacements of all load cases, (n_dof, l) each."""
        both = np.zeros((2, self.freedom.n_dof, len(cases)))
        for column, (name, table) in enumerate(cases.items()):
            place = f"{where}.loads.{name}"
            both[0, :, column], both[1, :, column] = (
                self.case(table, place),
                self.given(table, place),
            )
        return both[0], both[1]

    def given(self, table: Mapping[str, Any], where: str) -> Array:
        """Prescribed displacements of fixed degrees of freedom, (n_dof,) [m, rad].

        Raises ShellError for a component that no support holds.
        """
        out = np.zeros((self.freedom.n_dof // DOFS, DOFS))
        held = np.zeros(out.size, dtype=bool)
        held[self.freedom.fixed] = True
        for name, entry in table.items():
            for component, value in (entry.get("motion") or {}).items():
                place = f"{where}.{name}.motion.{component}"
                if component not in COMPONENTS:
                    raise ShellError(
                        f"{place}: expected some of {', '.join(COMPONENTS)}"
                        + did_you_mean(component, COMPONENTS)
                    )
                nodes = self._shares(entry.get("at"), "motion", f"{where}.{name}")[0]
                column = COMPONENTS.index(component)
                if not held.reshape(out.shape)[nodes, column].all():
                    raise ShellError(
                        f"{place}: no support holds {component} of {entry['at']!r}; expected a "
                        "support with it, whose displacement this is instead of 0"
                    )
                out[nodes, column] = float(value)
        return out.ravel()

    def _add(self, forces: Array, entry: Mapping[str, Any], where: str) -> None:
        given = [key for key in KINDS if entry.get(key) is not None]
        if not given and entry.get("motion") is None:
            raise ShellError(f"{where}: no load; expected one of {', '.join((*KINDS, 'motion'))}")
        if entry.get("sine") is not None and not set(given) & set(ON_CELLS):
            raise ShellError(f"{where}.sine: expected together with {' or '.join(ON_CELLS)}")
        at = entry.get("at")
        for key in given:
            place = f"{where}.{key}"
            if key == "gravity":
                if at is not None:
                    raise ShellError(f"{where}.at = {at!r}: gravity acts on the whole shell")
                forces += self._gravity(vector(entry[key], place))
            elif key in ON_CELLS:
                forces[: self.mesh.n_node, :3] += self._on_cells(key, entry, where)
            else:
                nodes, share, measure = self._shares(at, key, where)
                value = vector(entry[key], place) * (measure if key == "force_per_length" else 1.0)
                columns = slice(3, 6) if key == "moment" else slice(0, 3)
                forces[nodes, columns] += share[:, None] * value
                if key != "moment" and str(at) in self.mesh.curves and measure > 0.0:
                    forces[: self.mesh.n_node, 3:] += self._bowing(str(at), value / measure)

    def _bowing(self, curve: str, per_length: Array) -> Array:
        """Moments of a uniform force per length on the rotations of its nodes, (n, 3) [N m]."""
        mesh, out = self.mesh, np.zeros((self.mesh.n_node, 3))
        if not self._bow:
            return out
        row, side = mesh.edges.on(mesh.curves[curve])
        e3 = cell_axes(mesh, self.regions)[mesh.edges.owner[side], :, 2]
        i, j = mesh.edges.nodes[mesh.edges.number[side]].T
        along = mesh.points_G[j] - mesh.points_G[i]
        size = np.linalg.norm(along, axis=1)
        across = np.cross(along, e3) @ per_length  # L p . n
        share = np.bincount(row)[row]  # a side of several cells is divided equally
        moment = (self._bow / 12.0 * size * across / share)[:, None] * e3
        np.add.at(out, j, moment)
        np.add.at(out, i, -moment)
        return out

    def _shares(self, at: Any, key: str, where: str) -> tuple[IntArray, Array, float]:
        """Nodes, their weights, and the length or area of the group; 0 for a link."""
        if at is None:
            raise ShellError(f"{where}.at: missing, {key} needs a group or a link")
        for row, link in enumerate(self.freedom.links):
            if link.name == at and key != "force_per_length":
                return np.array([self.mesh.n_node + row]), np.ones(1), 0.0
        of = group(self.mesh, str(at), f"{where}.at")
        if key == "force_per_length" and of.kind != "curve":
            raise ShellError(f"{where}.at = {at!r}: a {of.kind}, {key} needs a physical curve")
        total = float(of.weights.sum())
        return of.nodes, of.weights / total, total

    def _gravity(self, acceleration: Array) -> Array:
        motion = np.zeros((self.freedom.n_dof // DOFS, DOFS))
        motion[: self.mesh.n_node, :3] = acceleration
        return np.asarray(self._mass(motion.ravel()).reshape(motion.shape))

    def _on_cells(self, key: str, entry: Mapping[str, Any], where: str) -> Array:
        chosen = self._chosen(key, entry.get("at"), where)
        out = np.zeros((self.mesh.n_node, 3))
        for region in chosen:
            cells, t = region.nodes, region.geometry
            intensity = self._intensity(entry, region, where)  # (c, points)
            if key == "pressure":
                value = entry[key]
                if isinstance(value, bool) or not isinstance(value, int | float):
                    raise ShellError(f"{where}.{key} = {value!r}: expected a number [N/m2]")
                direction = float(value) * t.A_GE[:, :, 2]
            else:
                direction = np.tile(vector(entry[key], f"{where}.{key}"), (len(cells), 1))
            corner = (t.weight * intensity) @ t.interpolation
            np.add.at(out, cells, corner[:, :, None] * direction[:, None, :])
        return out

    def _chosen(self, key: str, at: Any, where: str) -> list[Region]:
        """Regions of a physical surface, or all of them."""
        chosen = [region for region in self.regions if at in (None, region.name)]
        if not chosen:
            known = self.mesh.regions
            raise ShellError(
                f"{where}.at = {at!r}: {key} needs a physical surface; the mesh has "
                + ", ".join(known)
                + did_you_mean(str(at), known)
            )
        return chosen

    def _intensity(self, entry: Mapping[str, Any], region: Region, where: str) -> Array:
        corners = self.mesh.points_G[region.nodes]
        if entry.get("sine") is None:
            return np.ones(region.geometry.weight.shape)
        length = vector(entry["sine"], f"{where}.sine")
        waves = np.divide(np.pi, length, out=np.zeros(3), where=length != 0.0)
        factors = np.where(
            length != 0.0, np.sin((region.geometry.interpolation @ corners) * waves), 1.0
        )
        return np.asarray(factors.prod(axis=2))


def resultant(mesh: ShellMesh, freedom: Freedom, forces: Array, about_G: Array) -> Array:
    """Force and moment of nodal forces, (6, k) [N, N m].

    Parameters
    ----------
    mesh : of the shell
    freedom : with the links, whose points follow the nodes
    forces : (n_dof, k) [N, N m]
    about_G : (3,) point of the moments [m]
    """
    ends = [link.point_G[None] for link in freedom.links]
    arms = np.concatenate([mesh.points_G, *ends]) - about_G
    rows = forces.reshape(len(arms), DOFS, forces.shape[1])
    moment = rows[:, 3:].sum(axis=0) + np.cross(arms[:, :, None], rows[:, :3], axis=1).sum(axis=0)
    return np.concatenate([rows[:, :3].sum(axis=0), moment])
