"""A triangle or quadrilateral in UFL: what the text of elements, mass and loads is written with.

All is in the axes E of the cell's laminate, e3 normal to it; the kernel turns it to G. Corners run
around the cell, sides from corner k to the next. Corner i has the unknowns u, v, w, bx, by, tz:
(bx, by) the rotation of the normal, u + z bx and v + z by, so bx = ry and by = -rx; tz = rz.

Numbers of quadrilaterals are taken at points, written out one by one: an integral is a sum over
`points`. Python numbers enter as float(): NumPy's would take UFL's vectors apart.
"""

from math import prod
from typing import Any, NamedTuple

from ufl import as_matrix, as_vector, dot, sqrt

from ...fenicsx import Symbols, symbols
from ..shell_cells import AT_GAUSS, CENTRE, GAUSS, POINTS, slopes

# Data of a cell, one row of numbers: `cell_table` fills it.
SHAPES: dict[str, tuple[int, ...]] = {
    "A_GE": (3, 3),  # rotation, v_G = A_GE v_E
    "A": (3, 3),  # membrane [N/m]
    "B": (3, 3),  # coupling [N]
    "D": (3, 3),  # bending [N m]
    "Ds": (2, 2),  # transverse shear, corrected [N/m]
    "mass": (3,),  # moments of the density over the thickness: kg/m2, kg/m, kg
    "beta0": (),  # of "opt"
    "drilling_factor": (),
    "bow": (),  # of the sides of quadrilaterals, that of the triangles (membranes)
    "width_ratio": (4,),  # of the sides of quadrilaterals
    "N": (3,),  # resultants of a prestress: Nxx, Nyy, Nxy [N/m]
    "in_plane": (),  # 1: the prestress works on rotations about the normal, 0: it does not
    "p": (4,),  # pressure along e3 at the points of integration [N/m2]
}


def _columns() -> dict[str, tuple[int, tuple[int, ...]]]:
    columns, first = {}, 0
    for name, shape in SHAPES.items():
        columns[name] = first, shape
        first += prod(shape)
    return columns


COLUMNS = _columns()  # name -> first column, shape
SIZE = sum(prod(shape) for shape in SHAPES.values())

AROUND = {3: (0, 1, 2), 4: (0, 1, 3, 2)}  # DOLFINx's corner for each corner around the cell
KIND = {3: "triangle", 4: "quadrilateral"}


class Corner(NamedTuple):
    """The unknowns of a corner in E [m, rad]."""

    u: Any
    v: Any
    w: Any
    bx: Any
    by: Any
    tz: Any


class Point(NamedTuple):
    """A point of integration.

    Attributes
    ----------
    weight : its area [m2]
    xy : place from the centroid of the area [m]
    N, grad : the functions of the corners (numbers), and their gradients [1/m]
    bulges : gradients of the functions P_k of the sides, 1 in the middle of side k, 0 on others
    edges : fields of the sides; their component along side k is 1 on it, and 0 along the others
    """

    weight: Any
    xy: Any
    N: list[float]
    grad: list[Any]
    bulges: list[Any]
    edges: list[Any]

    def of(self, values: list[Any]) -> Any:
        """Value of a quantity that corners have."""
        return sum(n * value for n, value in zip(self.N, values, strict=True))

    def slope(self, values: list[Any]) -> Any:
        """Its gradient."""
        return sum((g * value for g, value in zip(self.grad, values, strict=True)), ZERO)


class Mapping(NamedTuple):
    """A quadrilateral at a point of (xi, eta).

    Determinant, gradients of the functions of the corners, derivatives of the place by xi and eta,
    gradients of xi and eta.
    """

    det: Any
    grad: list[Any]
    by_xi: Any
    by_eta: Any
    grad_xi: Any
    grad_eta: Any


ZERO = as_vector((0.0, 0.0))


class Cell:
    """A cell with k corners, and its laminate.

    Attributes
    ----------
    A, B, D, Ds and others : entries of the table by their names, see `SHAPES`
    corners, feet : unknowns of the corners, and of their feet in the mean plane of a warped cell:
        u - d bx, v - d by at the height d
    sides : (start, end) corners of each side
    length, tangent : of the sides [m]
    area, points : [m2], points of integration
    gradient_points : those for products of gradients
    centre : gradients of the functions of the corners there
    mapping : of the centre of a quadrilateral
    """

    A_GE: Any
    A: Any
    B: Any
    D: Any
    Ds: Any
    mass: Any
    beta0: Any
    drilling_factor: Any
    bow: Any
    width_ratio: Any
    N: Any
    in_plane: Any
    p: Any

    def __init__(self, given: Symbols, k: int) -> None:
        self.k = k
        for name, (first, shape) in COLUMNS.items():
            setattr(self, name, _entry(given.table, first, shape))
        self.sides = [(i, (i + 1) % k) for i in range(k)]
        axes = [as_vector([self.A_GE[i, j] for i in range(3)]) for j in range(3)]
        places = [as_vector([given.corners[i, j] for j in range(3)]) for i in AROUND[k]]
        middle = sum(places[1:], places[0]) / float(k)
        local = [[dot(place - middle, axis) for axis in axes] for place in places]
        self.xy = [as_vector((x, y)) for x, y, _ in local]
        self.height = [z for _, _, z in local]
        self.corners = [_corner(given.unknowns, i) for i in AROUND[k]]
        self.feet = self.corners
        if k == 3:
            self._triangle()
        else:
            self._quadrilateral()

    def _sides(self) -> list[Any]:
        edges = [self.xy[j] - self.xy[i] for i, j in self.sides]
        self.length = [sqrt(dot(edge, edge)) for edge in edges]
        self.tangent = [edge / L for edge, L in zip(edges, self.length, strict=True)]
        return edges

    def _triangle(self) -> None:
        edges = self._sides()
        signed = edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]
        self.area = 0.5 * abs(signed)
        # corner i is opposite to the side that starts at the next corner
        grad = [as_vector((-edges[j][1], edges[j][0])) / signed for _, j in self.sides]
        self.centre = grad
        self.points = []
        for N in POINTS.tolist():  # the area coordinates
            bulges = [4.0 * (N[i] * grad[j] + N[j] * grad[i]) for i, j in self.sides]
            edges = [
                L * (N[i] * grad[j] - N[j] * grad[i])
                for L, (i, j) in zip(self.length, self.sides, strict=True)
            ]
            xy = sum((N[i] * self.xy[i] for i in range(3)), ZERO)
            self.points.append(Point(self.area / 3.0, xy, N, grad, bulges, edges))
        thirds = [1.0 / 3.0] * 3
        self.gradient_points = [Point(self.area, ZERO, thirds, grad, [], [])]

    def _quadrilateral(self) -> None:
        shapes = AT_GAUSS.tolist()
        maps = [_mapped(self.xy, at) for at in slopes(GAUSS)]
        self.mapping = _mapped(self.xy, CENTRE)
        self.centre = self.mapping.grad
        self.area = sum(abs(at.det) for at in maps)
        centroid = ZERO
        for at, N in zip(maps, shapes, strict=True):
            for i in range(4):
                centroid += abs(at.det) / self.area * N[i] * self.xy[i]
        self.xy = [place - centroid for place in self.xy]
        self._sides()
        self.points = []
        for (xi, eta), N, at in zip(GAUSS.tolist(), shapes, maps, strict=True):
            to_xi, to_eta = at.grad_xi, at.grad_eta
            # P_1 = (1 - xi^2) (1 - eta)/2 and so on around the cell
            bulges = [
                -xi * (1 - eta) * to_xi - 0.5 * (1 - xi**2) * to_eta,
                0.5 * (1 - eta**2) * to_xi - eta * (1 + xi) * to_eta,
                -xi * (1 + eta) * to_xi + 0.5 * (1 - xi**2) * to_eta,
                -0.5 * (1 - eta**2) * to_xi - eta * (1 - xi) * to_eta,
            ]
            # along xi between sides 1-2 and 4-3, along eta between sides 2-3 and 1-4
            along = [
                0.25 * (1 - eta) * to_xi,
                0.25 * (1 + xi) * to_eta,
                -0.25 * (1 + eta) * to_xi,
                -0.25 * (1 - xi) * to_eta,
            ]
            edges = [L * field for L, field in zip(self.length, along, strict=True)]
            xy = sum((N[i] * self.xy[i] for i in range(4)), ZERO)
            self.points.append(Point(abs(at.det), xy, N, at.grad, bulges, edges))
        self.gradient_points = self.points
        self.feet = [
            corner._replace(u=corner.u - d * corner.bx, v=corner.v - d * corner.by)
            for corner, d in zip(self.corners, self.height, strict=True)
        ]

    def excess(self, corners: list[Corner]) -> list[Any]:
        """Difference between tz of each corner and the rotation (v,x - u,y)/2 of the cell.

        Zero for a rigid motion and for constant strain; the rotation is that of the centre.
        """
        turn = 0.5 * sum(
            g[0] * corner.v - g[1] * corner.u
            for g, corner in zip(self.centre, corners, strict=True)
        )
        return [corner.tz - turn for corner in corners]


def cell_of(k: int) -> Cell:
    """The cell with k corners."""
    return Cell(symbols(KIND[k], SIZE, 6 * k), k)


def _entry(table: Any, first: int, shape: tuple[int, ...]) -> Any:
    """A number, vector or matrix of the table."""
    if not shape:
        return table[first]
    if len(shape) == 1:
        return as_vector([table[first + i] for i in range(shape[0])])
    rows, columns = shape
    return as_matrix(
        [[table[first + columns * i + j] for j in range(columns)] for i in range(rows)]
    )


def _corner(unknowns: Any, i: int) -> Corner:
    """The kernel turns them from G to E.

    Paper: Eq. (23).
    """
    u, v, w, rx, ry, rz = (unknowns[6 * i + j] for j in range(6))
    return Corner(u, v, w, bx=ry, by=-rx, tz=rz)


def _mapped(xy: list[Any], slopes: Any) -> Mapping:
    """At a point with derivatives `slopes` (4, 2) of the corners' functions by xi and eta."""
    S = slopes.tolist()
    by_xi, by_eta = (sum((S[i][a] * xy[i] for i in range(4)), ZERO) for a in range(2))
    det = by_xi[0] * by_eta[1] - by_xi[1] * by_eta[0]
    grad_xi = as_vector((by_eta[1], -by_eta[0])) / det
    grad_eta = as_vector((-by_xi[1], by_xi[0])) / det
    grad = [S[i][0] * grad_xi + S[i][1] * grad_eta for i in range(4)]
    return Mapping(det, grad, by_xi, by_eta, grad_xi, grad_eta)
