"""Places of a mechanism: their positions at the start, and their markers."""

from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.model.model import GROUND
from ..errors import InputError, nearest
from ..math.arrays import Array
from ..math.rotations import frame_from_axis, vector_to_matrix
from ..package import Interface, ModalPackage
from .tables import MarkerTable

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Mechanism


class Places:
    """Interfaces of bodies and points of the ground, and their markers.

    Attributes
    ----------
    known : "BODY.INTERFACE" -> body index, interface
    markers : in the order of the requests
    r_start, A_start : (nb, 3) [m], (nb, 3, 3) frames of the bodies at the given start
    """

    def __init__(self, mechanism: "Mechanism", packages: dict[str, ModalPackage]) -> None:
        bodies = mechanism.bodies
        self._ground = {
            f"ground.{name}": np.array(point.position, dtype=float)
            for name, point in mechanism.ground.items()
        }
        self.known: dict[str, tuple[int, Interface]] = {}
        for index, (name, body) in enumerate(bodies.items()):
            if body.kind == "rigid":
                interfaces = [_rigid(point, at.position) for point, at in body.interfaces.items()]
            else:
                interfaces = list(packages[name].interfaces)
            self.known |= {f"{name}.{i.name}": (index, i) for i in interfaces}
        self.r_start = np.array([body.position for body in bodies.values()], dtype=float)
        turns = [np.radians(np.array(b.rotation_deg, dtype=float)) for b in bodies.values()]
        self.A_start = np.array([vector_to_matrix(turn) for turn in turns])
        self.markers: list[MarkerTable] = []

    def marker(self, key: str, place: str, A_GM: Array) -> int:
        """Add a marker at a place whose axes are A_GM (3, 3) in the starting position.

        Parameters
        ----------
        key : key of the case file, for messages
        place : name of a place: BODY.INTERFACE, or a point of the ground
        A_GM : axes of the marker at the start (3, 3)

        Raises
        ------
        InputError
            A package has no such interface; `key` is that of the case file.
        """
        if place in self._ground:
            return self._add(MarkerTable(GROUND, self._ground[place], A_GM))
        if place not in self.known:
            hint = nearest(place, self.known)
            raise InputError(f'{key} = "{place}": no such interface{hint}')
        body, at = self.known[place]
        A_BM = self.A_start[body].T @ A_GM
        return self._add(
            MarkerTable(body, at.position_B, A_BM, at.phi_B, at.psi_B, at.H_B, at.H_psi_B)
        )

    def ground_axes(self) -> int:
        """Add a marker with the global axes, for loads of fixed direction."""
        return self._add(MarkerTable(GROUND, np.zeros(3)))

    def _add(self, marker: MarkerTable) -> int:
        self.markers.append(marker)
        return len(self.markers) - 1

    def shift(self, one: int, two: int) -> Array:
        """Return the vector (3,) from marker one to two at the given start, in axes of one [m]."""
        x, A = self.frame(one)
        return np.asarray(A.T @ (self.frame(two)[0] - x))

    def frame(self, marker: int) -> tuple[Array, Array]:
        """Return place (3,) [m] and axes (3, 3) of a marker at the given start, global."""
        table = self.markers[marker]
        if table.body == GROUND:
            return table.x, table.A
        A_GB = self.A_start[table.body]
        return self.r_start[table.body] + A_GB @ table.x, A_GB @ table.A


def axes(z: list[float], x: list[float] | None = None) -> Array:
    """Return a rotation matrix (3, 3) with its third column along z, its first along x."""
    if x is None:
        return frame_from_axis(np.array(z, dtype=float))
    third = np.array(z, dtype=float) / np.linalg.norm(z)
    first = np.array(x, dtype=float) - (np.array(x) @ third) * third
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(third, first), third])


def _rigid(name: str, position: list[float]) -> Interface:
    none = np.zeros((3, 0))
    return Interface(
        name,
        "node",
        np.zeros(0, dtype=np.int64),
        np.zeros(0),
        np.array(position, dtype=float),
        np.eye(3),
        none,
        none,
    )
