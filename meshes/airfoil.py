"""Airfoil section: skin along a contour, spar webs and caps, nine-node quadrilaterals.

x = x2 runs from nose to tail, y = x3 from the lower to the upper side. The skin is divided into
rows at given depths below the contour, so that every ply ends on element edges. In front of the
trailing edge, where the space between the skins closes, a wall of the skin's thickness ends the
section. Seen from the nose:

    skin-front | web-1 | cap-upper, cap-lower | ... | web-n | skin-rear

(one web: no caps; none: a single region "skin"). The contour is the physical curve "outer".

    python airfoil.py airfoils/naca0012.dat [OUT.msh]    opens the mesh in gmsh, or writes it
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Numbers = float | Sequence[float]

DEFAULTS: dict[str, Numbers] = {
    "chord": 0.3,  # [m]
    "origin": 0.0,  # place of the section's origin, fraction of the chord
    "skin_front": 0.001,  # thickness of the skin before the first web [m]
    "skin_rear": 0.001,  # and behind the last one
    "cap": 0.001,  # thickness of the skin between the webs
    "webs": [0.2, 0.5],  # middle of each web, fractions of the chord, ascending
    "web": [0.001, 0.001],  # thickness of each web [m]
    "faces": [0.0005, 0.001],  # depths where rows of the skin end [m], among them each thickness
    "density": 1.0,  # of elements along the walls
}  # and rows_web_1, ...: ends of the rows of each web, fractions of it from its rear face
ROWS_WEB = (0.5, 1.0)

SAMPLES = 4001  # of the contour, to start iterations from
FIRST = 1 / 2  # length of the first element at a corner over the thinnest wall
GROWTH = 0.25  # of the elements' length with the distance from a corner
LONGEST = 1 / 20  # of the chord
TURN = 0.2  # largest change of direction over one element [rad]
CURVED = 0.7  # length over sqrt(thickness x radius), for the bending of thin curved walls
CLOSE = 2e-4  # distance of the elements' edges from the contour over the skin's thickness
OPENING = 1.0  # height of the hollow at the rear wall over the skin's thickness
BENT = 0.5  # depth over radius of curvature from which rows are spaced by their own length


class Contour:
    """The outer contour by its parameter s, from the upper trailing edge to the lower one.

    Positions below the contour: s and depth d along the inward normal.
    """

    def __init__(self, points: Array) -> None:
        step = np.concatenate([[True], np.linalg.norm(np.diff(points, axis=0), axis=1) > 0.0])
        points = points[step]
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        self._spline = CubicSpline(length, points)
        self.grid = np.linspace(0.0, length[-1], SAMPLES)
        self.nose = float(self.grid[np.argmax(self.curvature(self.grid))])

    def _frame(self, s: Array) -> tuple[Array, Array, Array]:
        """Tangent, speed, curvature (positive where the inside is the hollow side)."""
        first, second = self._spline(s, 1), self._spline(s, 2)
        speed = np.linalg.norm(first, axis=-1)
        bend = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        return first / speed[..., None], speed, bend / speed**3

    def curvature(self, s: Array) -> Array:
        """[1/m]."""
        return self._frame(s)[2]

    def at(self, s: Array, d: Array | float) -> Array:
        """Point at s and depth d, (..., 2)."""
        s, d = np.broadcast_arrays(s, np.asarray(d, float))
        tangent, _, _ = self._frame(s)
        normal = np.stack([-tangent[..., 1], tangent[..., 0]], axis=-1)
        return np.asarray(self._spline(s) + d[..., None] * normal)

    def side(self, upper: bool) -> Array:
        """Samples of s on one side, from the tail on."""
        mask = self.grid <= self.nose if upper else self.grid >= self.nose
        return self.grid[mask] if upper else self.grid[mask][::-1]

    def where(self, x: Array | float, d: Array | float, upper: bool) -> Array:
        """s on one side where the point at depth d has the coordinate x."""
        x, d = np.broadcast_arrays(np.asarray(x, float), np.asarray(d, float))
        samples = self.side(upper)
        s = np.empty(x.shape)
        for i in np.ndindex(x.shape):
            places = self.at(samples, d[i])[:, 0]
            before = np.flatnonzero((places[:-1] >= x[i]) & (places[1:] < x[i]))
            if not before.size:
                raise ValueError(f"webs: at x2 = {x[i]:.4g} m there is no room between the skins")
            k = before[0]
            s[i] = np.interp(-x[i], -places[k : k + 2], samples[k : k + 2])
        for _ in range(4):
            tangent, speed, curvature = self._frame(s)
            slope = (1.0 - curvature * d) * speed * tangent[..., 0]
            s = s - (self.at(s, d)[..., 0] - x) / slope
        return s

    def meeting_points(self, d: Array) -> tuple[Array, Array]:
        """Both s with one common point at depth d: at the nose, or on the medial axis behind it."""
        upper, lower = np.full(d.shape, self.nose), np.full(d.shape, self.nose)
        for i in np.flatnonzero(d * self.curvature(np.array(self.nose)) > 1.0):
            a, b = self.side(True)[::-1], self.side(False)[::-1]
            p, q = self.at(a, d[i]), self.at(b, d[i])
            # the two sides cross where the upper one falls below the lower one
            gap = p[:, 1] - np.interp(p[:, 0], *_ascending(q))
            k = int(np.flatnonzero((gap[:-1] < 0.0) & (gap[1:] >= 0.0))[-1])
            s = np.array([a[k], np.interp(p[k, 0], *_ascending(q, b))])
            for _ in range(20):
                tangent, speed, curvature = self._frame(s)
                slope = ((1.0 - curvature * d[i]) * speed)[:, None] * tangent
                away = self.at(s[:1], d[i])[0] - self.at(s[1:], d[i])[0]
                s = s - np.linalg.solve(np.stack([slope[0], -slope[1]], axis=1), away)
            upper[i], lower[i] = s
        return upper, lower


def _ascending(q: Array, value: Array | None = None) -> tuple[Array, Array]:
    """Abscissae that ascend, and y (or another value) there, for interpolation."""
    order = np.argsort(q[:, 0], kind="stable")
    return q[order, 0], (q[:, 1] if value is None else value)[order]


class Mesh:
    """Nodes and cells, added block by block; coincident nodes are merged."""

    def __init__(self) -> None:
        self.points: list[Array] = []
        self.cells: dict[str, list[Any]] = {}
        self.outer: list[Any] = []
        self._n = 0

    def add(self, grid: Array, region: str, outer: bool = False) -> None:
        """A block of nodes (2 m + 1, 2 n + 1, 2); its edge with second index 0 may be outer."""
        m, n, _ = grid.shape
        number = self._n + np.arange(m * n).reshape(m, n)
        self._n += m * n
        self.points.append(grid.reshape(-1, 2))
        i, j = np.arange(0, m - 1, 2)[:, None], np.arange(0, n - 1, 2)[None, :]
        steps = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))
        cells = np.stack([number[i + a, j + b] for a, b in steps], axis=-1).reshape(-1, 9)
        self.cells.setdefault(region, []).append(cells)
        if outer:
            self.outer.append(number[i[:, 0][:, None] + np.array([0, 2, 1]), 0])

    def write(self, gmsh: Any) -> None:
        """Write nodes, cells and groups to gmsh's current model."""
        points = np.concatenate(self.points)
        near = 1e-8 * float(np.ptp(points, axis=0).max())
        pairs = cKDTree(points).query_pairs(near, output_type="ndarray")
        graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(self._n,) * 2)
        n_node, number = connected_components(graph, directed=False)
        merged = np.zeros((n_node, 3))
        merged[number, :2] = points
        number = number + 1  # gmsh counts from 1
        for row, (region, blocks) in enumerate(self.cells.items(), start=1):
            gmsh.model.addDiscreteEntity(2, row)
            if row == 1:
                tags = np.arange(1, n_node + 1)
                gmsh.model.mesh.addNodes(2, row, tags.tolist(), merged.ravel().tolist())
            cells = number[np.concatenate(blocks)]
            gmsh.model.mesh.addElementsByType(row, 10, [], cells.ravel().tolist())
            gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [row]), region)
        gmsh.model.addDiscreteEntity(1, 1)
        lines = number[np.concatenate(self.outer)]
        gmsh.model.mesh.addElementsByType(1, 8, [], lines.ravel().tolist())
        gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, [1]), "outer")


def with_middles(ends: Array) -> Array:
    """Ends of elements and the middles between them."""
    return np.insert(ends, np.arange(1, len(ends)), 0.5 * (ends[:-1] + ends[1:]))


def spaced(size: Array, place: Array, count_by: float) -> Array:
    """Ends of elements from 0 to 1 with lengths by `size`, given at positions along a line."""
    density = count_by / size
    total = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(place))])
    n = max(1, int(np.ceil(total[-1] - 1e-9)))
    ends = np.interp(np.arange(n + 1) / n * total[-1], total, place)
    return np.asarray((ends - place[0]) / (place[-1] - place[0]))


class Section:
    """The blocks of skin, rear wall and webs, in the order of the contour."""

    def __init__(self, contour: Contour, table: Mapping[str, Any]) -> None:
        self.contour = contour
        self.density = float(table["density"])
        chord = float(table["chord"])
        origin = float(table["origin"]) * chord
        webs = np.atleast_1d(np.asarray(table["webs"], float))
        self.n_web = len(webs)
        self.x_web = webs * chord - origin
        self.t_web = np.atleast_1d(np.asarray(table["web"], float))[: self.n_web]
        self.front, self.rear = float(table["skin_front"]), float(table["skin_rear"])
        self.cap = float(table["cap"])
        self.faces = np.unique(np.atleast_1d(np.asarray(table["faces"], float)))
        self.rows_web = [
            np.concatenate([[0.0], np.atleast_1d(table.get(f"rows_web_{i + 1}", ROWS_WEB))])
            for i in range(self.n_web)
        ]
        self.longest = LONGEST * chord
        self.first = FIRST * min([self.front, self.rear, *self.t_web])
        self.mesh = Mesh()
        self.x_tail = self._tail()
        self.corners = [float(contour.where(self.x_tail, 0.0, upper)) for upper in (True, False)]

    def depths(self, thickness: float) -> Array:
        """Depths of the nodes of a skin."""
        inside = self.faces[self.faces < thickness * (1.0 - 1e-9)]
        return with_middles(np.concatenate([[0.0], inside, [thickness]]))

    def _tail(self) -> float:
        """x2 of the outer face of the rear wall: behind it the skins would meet."""
        t = self.rear
        upper, lower = (self.contour.at(self.contour.side(up), t) for up in (True, False))
        ends = [self.contour.at(self.contour.side(up)[0], 0.0)[0] for up in (True, False)]
        end = min(ends) - 1e-9 * float(np.ptp(upper[:, 0]))
        x = np.linspace(end - t, 0.5 * (end + upper[:, 0].min()), SAMPLES)
        opening = np.interp(x, *_ascending(upper)) - np.interp(x, *_ascending(lower))
        wide = np.flatnonzero(opening >= OPENING * t)
        if not wide.size:
            raise ValueError(f"skin_rear = {t:g}: too thick, no hollow is left in the airfoil")
        tail = float(x[wide[0]] + t)
        if self.n_web and tail - t <= self.x_web[-1] + 0.5 * self.t_web[-1]:
            raise ValueError(
                f"webs: the last one lies behind x2 = {tail - t:.4g} m, where the skins meet"
            )
        return tail

    def build(self) -> Mesh:
        """All blocks."""
        columns = {}
        for up in (True, False):
            columns[up] = [self._web_columns(i, up) for i in range(self.n_web)]
            self.corners += [float(s) for web in columns[up] for s in (web[0], web[-1])]
        inner = {}
        for up in (True, False):
            for i, web in enumerate(columns[up]):
                inner[up, i] = self._junction(i, web, up)
            self._skins(columns[up], up)
        for i in range(self.n_web):
            v = self._stations_straight(inner[False, i][0], inner[True, i][0])
            grid = (1.0 - v) * inner[False, i] + v * inner[True, i]
            self.mesh.add(grid, f"web-{i + 1}")
        depths = self.depths(self.rear)
        low, high = (self.contour.at(self._mitre(up)(depths), depths) for up in (False, True))
        v = self._stations_straight(low[0], high[0])
        self.mesh.add((1.0 - v) * low + v * high, self._region(self.n_web, True), outer=True)
        return self.mesh

    def _region(self, bay: int, upper: bool) -> str:
        """Skin of the bay behind web number `bay` (from 0 for the nose)."""
        if not self.n_web:
            return "skin"
        if bay in (0, self.n_web):
            return "skin-rear" if bay else "skin-front"
        return "cap-upper" if upper else "cap-lower"

    def _thickness(self, bay: int) -> float:
        return self.front if bay == 0 else self.rear if bay == self.n_web else self.cap

    def _owner(self, web: int) -> int:
        """Bay with the skin that continues over a web: the thicker skin."""
        before, behind = self._thickness(web), self._thickness(web + 1)
        if before == behind:
            return web if web else min(1, self.n_web - 1)
        return web if before > behind else web + 1

    def _mitre(self, upper: bool) -> Any:
        return lambda d: self.contour.where(self.x_tail - d, d, upper)

    def _web_columns(self, web: int, upper: bool) -> Array:
        """s over the rows of a web, from its rear face on."""
        x = self.x_web[web] + self.t_web[web] * (0.5 - self.rows_web[web])
        thickness = self._thickness(self._owner(web))
        return self.contour.where(x, np.full(x.shape, thickness), upper)

    def _junction(self, web: int, columns: Array, upper: bool) -> Array:
        """Skin over a web; returns the nodes where the web begins, from its rear face on."""
        bay = self._owner(web)
        d = self.depths(self._thickness(bay))
        grid = self.contour.at(with_middles(columns)[:, None], d)
        self.mesh.add(grid if upper else grid[::-1], self._region(bay, upper), outer=True)
        return np.asarray(grid[:, -1])

    def _skins(self, columns: Sequence[Array], upper: bool) -> None:
        """Skin of every bay on one side."""
        for bay in range(self.n_web + 1):
            region, d = self._region(bay, upper), self.depths(self._thickness(bay))
            if bay == self.n_web:
                rear = self._mitre(upper)(d)
            else:
                rear = np.full(d.shape, columns[bay][-1])
            if bay > 0:
                self._skin(rear, np.full(d.shape, columns[bay - 1][0]), d, region, upper)
                continue
            tip = self.contour.meeting_points(d)[0 if upper else 1]
            bent = self._bent(d[-1], upper, rear[0])
            if bent is None:
                self._skin(rear, tip, d, region, upper)
            else:
                begin = np.full(d.shape, bent)
                self._skin(rear, begin, d, region, upper)
                self._skin(begin, tip, d, region, upper, by_length=True)

    def _bent(self, thickness: float, upper: bool, rear: float) -> float | None:
        """s where the strongly curved part of the nose begins; None if the skin is thin there."""
        s = self.contour.side(upper)
        bend = self.contour.curvature(s) * thickness
        if bend[-1] <= BENT:
            return None
        begin = s[np.flatnonzero(bend <= 0.3 * BENT)[-1]]
        begin += -3.0 * thickness if upper else 3.0 * thickness
        if abs(begin - self.contour.nose) >= abs(rear - self.contour.nose) - thickness:
            raise ValueError(
                f"skin_front = {thickness:g}: too thick for the nose in front of the first web"
            )
        return float(begin)

    def _skin(
        self, a: Array, b: Array, d: Array, region: str, upper: bool, by_length: bool = False
    ) -> None:
        """Skin from column s = a(d) to column s = b(d); b is farther from the tail."""
        line = np.linspace(a[0], b[0], 400)
        dist = np.abs(line[:, None] - np.array(self.corners)).min(axis=1)
        size = np.minimum(self.first + GROWTH * dist, self.longest)
        bend = np.maximum(np.abs(self.contour.curvature(line)), 1e-12)
        size = np.minimum(size, np.minimum(TURN / bend, CURVED * np.sqrt(d[-1] / bend)))
        # degree-2 edges leave a contour of changing curvature by length^3 change / 125
        change = np.abs(np.gradient(self.contour.curvature(line), line)) + 1e-12
        size = np.minimum(size, np.cbrt(125.0 * CLOSE * d[-1] / change))
        u = with_middles(spaced(size, np.abs(line - a[0]), self.density))
        s = a + u[:, None] * (b - a)
        if by_length:
            fine = np.linspace(0.0, 1.0, 400)[:, None]
            line = a + fine * (b - a)
            step = 1.0 - self.contour.curvature(line) * d
            length = np.zeros(line.shape)
            length[1:] = np.cumsum(0.5 * (step[1:] + step[:-1]), axis=0)
            for j in range(d.size):
                s[:, j] = np.interp(u * length[-1, j], length[:, j], line[:, j])
            s[-1] = b
        grid = self.contour.at(s, d)
        self.mesh.add(grid if upper else grid[::-1], region, outer=True)

    def _stations_straight(self, a: Array, b: Array) -> Array:
        """Stations along a straight wall between two corners, (n, 1, 1)."""
        line = np.linspace(0.0, float(np.linalg.norm(b - a)), 400)
        size = np.minimum(self.first + GROWTH * np.minimum(line, line[-1] - line), self.longest)
        return with_middles(spaced(size, line, self.density))[:, None, None]


def build(gmsh: Any, parameters: Mapping[str, Any], coordinates: Any) -> None:
    """Fill gmsh's current model with the mesh of an airfoil section.

    Parameters
    ----------
    gmsh : the module, initialised
    parameters : see DEFAULTS, numbers or lists of numbers
    coordinates : (n, 2) of the contour for unit chord, from the upper trailing edge around the
        nose to the lower one

    Raises
    ------
    ValueError : sizes that do not fit into the contour.
    """
    table: dict[str, Any] = {**DEFAULTS, **parameters}
    points = np.asarray(coordinates, float)
    chord = float(table["chord"])
    points = chord * (points - np.array([float(table["origin"]), 0.0]))
    Section(Contour(points), table).build().write(gmsh)


def main(arguments: Sequence[str]) -> None:
    """Show the mesh of a file of coordinates, or write it."""
    import gmsh

    coordinates = np.loadtxt(arguments[0], skiprows=1)
    gmsh.initialize()
    build(gmsh, {}, coordinates)
    if len(arguments) > 1:
        gmsh.write(arguments[1])
    else:
        gmsh.fltk.run()
    gmsh.finalize()


if __name__ == "__main__":
    import sys

    main(sys.argv[1:])
