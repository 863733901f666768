"""The result of a run in memory: k output times, all arrays in SI units."""

from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from ..errors import InputError
from ..math.arrays import Array, IntArray
from ..package.common.dataset import Data
from .view import BodyView, Link

FORMAT = "plymotion result"
FORMAT_VERSION = (1, 3)
TABLES_VERSION = (2, 0)  # of a file with tables: older readers would miss what is in them

ENERGIES = ("kinetic", "strain", "potential", "drive_work")
ROUNDING = 1e3 * float(np.finfo(float).eps)  # of sums of energies, relative


class ResultError(InputError):
    """A result cannot be written or read; the message names file and dataset."""


@dataclass(frozen=True)
class Signal:
    """A named quantity over time."""

    name: str
    unit: str
    description: str
    values: Array  # (k,)


def energy_balance(energies: dict[str, Array]) -> Array:
    """Change of kinetic + strain + potential energy minus drive work, (k,) [J]."""
    e = energies
    balance = e["kinetic"] + e["strain"] + e["potential"] - e["drive_work"]
    return np.asarray(balance - balance[0])


def energy_in_play(energies: dict[str, Array]) -> float:
    """Largest of the kinetic energy, the work and the change of potential [J]; 1 if all are 0."""
    e = energies
    scale = max(
        float(np.max(np.abs(e["kinetic"]))),
        float(np.max(np.abs(e["drive_work"]))),
        float(np.ptp(e["potential"])),
    )
    return scale or 1.0


def relative_balance(energies: dict[str, Array]) -> Array:
    """Error of the energy balance over the energy in play, (k,) [-].

    Of the error, what rounding of the terms explains does not count: at rest there is nothing else.
    """
    terms = (float(np.max(np.abs(energies[name]), initial=0.0)) for name in ENERGIES)
    error = energy_balance(energies)
    error = np.where(np.abs(error) > ROUNDING * sum(terms), error, 0.0)
    return np.asarray(error / energy_in_play(energies))


@dataclass(frozen=True)
class BodyGeometry:
    """Geometry of a body for drawing, in its own frame."""

    name: str
    nodes_B: Annotated[Array, Data("n, 3", "m", "B", "rest positions of the drawn points")]
    connectivity: Annotated[IntArray, Data("i", text="rows of nodes_B, cell by cell")]
    offsets: Annotated[IntArray, Data("c+1", text="start of each cell in connectivity")]
    cell_types: Annotated[IntArray, Data("c", text="VTK cell types")]
    view: BodyView | None = None  # what is needed to show it in motion


@dataclass(frozen=True)
class RunResult:
    """All results of a run, at its k output times."""

    case: str
    run: str
    t: Array  # (k,)                                        [s]
    signals: tuple[Signal, ...]
    q: Array  # (k, n_pos) positions, Euler parameters, modal coordinates
    v: Array  # (k, n_vel) velocities
    multipliers: Array  # (k, n_c) reactions of the joints
    energies: dict[str, Array]  # ENERGIES, (k,) each       [J]
    bodies: tuple[BodyGeometry, ...]
    node_positions_G: Array  # (k, n, 3), bodies end to end [m]
    # largest constraint violation, (k,) each: position [m], rotation [rad], velocity [m/s]
    violations: dict[str, Array] = field(default_factory=dict)
    node_deflection: Array | None = None  # (k, n) magnitude of the elastic displacement [m]
    links: tuple[Link, ...] = ()  # joints, for pictures
    provenance: dict[str, Any] = field(default_factory=dict)  # versions, command, digest of inputs

    @property
    def energy_balance(self) -> Array:
        """Change of kinetic + strain + potential energy minus drive work, (k,) [J]."""
        return energy_balance(self.energies)

    @property
    def relative_balance(self) -> Array:
        """Error of the energy balance over the largest energy in play, (k,) [-]."""
        return relative_balance(self.energies)


def check_result(result: RunResult) -> None:
    """Raise ResultError with the name of the array if sizes of a result do not agree."""
    k = len(result.t)
    n = sum(len(body.nodes_B) for body in result.bodies)
    shapes: dict[str, tuple[Array, tuple[int, ...]]] = {
        "node_positions_G": (result.node_positions_G, (k, n, 3))
    }
    for name in ("q", "v", "multipliers"):
        array = getattr(result, name)
        shapes[name] = (array, (k, array.shape[1] if array.ndim == 2 else -1))
    if result.node_deflection is not None:
        shapes["node_deflection"] = (result.node_deflection, (k, n))
    for signal in result.signals:
        shapes[f"signals/{signal.name}"] = (signal.values, (k,))
    for group in ("energies", "violations"):
        for name, values in getattr(result, group).items():
            shapes[f"{group}/{name}"] = (values, (k,))
    missing = [name for name in ENERGIES if name not in result.energies]
    if missing:
        raise ResultError(f"energies/{missing[0]}: missing; expected {', '.join(ENERGIES)}")
    if not k or np.any(np.diff(result.t) <= 0):
        raise ResultError("t: expected at least one time, in ascending order")
    for name, (array, expected) in shapes.items():
        if np.shape(array) != expected:
            raise ResultError(f"{name}: expected shape {expected}, got {np.shape(array)}")
