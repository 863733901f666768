"""Resultants and ply stresses at a position along a flexible body, by modes or by equilibrium.

By equilibrium of the part beyond a section of a straight beam:

    F = sum F_m + int (g - a) dm
    M = sum (M_m + (x_m - x) x F_m) + int (x_dm - x) x (g - a) dm - int dh/dt

with the forces and moments of joints, force elements and loads at the markers m beyond the section,
point masses there, and the acceleration a and the spin h of the slices. The modes give a and the
place of the section, but no forces: what few modes miss of distributed inertia is not missing here.
Stresses of material damping are included.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.analysis.recovery import Look, Recording, Values, body_frames, stiffened
from ..dynamics.evaluation import series
from ..errors import InputError, few, nearest
from ..math.arrays import Array, IntArray
from ..math.rotations import skew, vectors_to_matrices
from ..mechanism.built_mechanism import BuiltMechanism
from ..package import ModalPackage
from ..package.body.package_schema import BodyRecovery
from ..package.common.recovery_schema import RESULTANTS, STRESSES, SectionRecovery
from ..strength.fatigue import StressLife, check_rainflow
from ..strength.weakest_plies import unit_stress_M

if TYPE_CHECKING:
    from ..inputs.case.tables.signals import PlyStressSignal, ResultantSignal


GAUSS = 0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)  # exact for products of linear functions
NEAR = 1e-9  # of the length


class Cut:
    """A section of a straight beam at x, and the mass beyond it.

    Raises
    ------
    InputError
        Not a straight beam with its sections; `key` is that of the case.
    """

    def __init__(
        self, key: str, built: BuiltMechanism, body: int, package: ModalPackage, x: float
    ) -> None:
        nodes, n = package.nodes_B, len(package.nodes_B)
        along = nodes[:, 0] - nodes[0, 0]
        line = np.column_stack([np.arange(n - 1), np.arange(1, n)]).ravel()
        straight = np.abs(nodes[:, 1:] - nodes[0, 1:]).max() <= NEAR * abs(along[-1])
        if (
            package.recovery is None
            or not np.array_equal(package.connectivity, line)
            or not straight
            or len(package.sections) not in (1, n)
        ):
            raise InputError(f'{key}.method = "equilibrium": expected a straight beam')
        self.built, self.model, self.body = built, built.model, body
        self.nodes, self.along, self.shapes = nodes, along, package.shapes_B
        self.A_BE = package.recovery.A_BE
        self.x = min(x, along[-1])
        end = along[-1] - self.x <= NEAR * along[-1]
        self._beyond = self.x + nodes[0, 0] + (-NEAR if end else NEAR) * along[-1]
        self._slices(np.array([section.M for section in package.sections]))
        loaded = series.loaded_markers(self.model)
        self.loads = [p for p, marker in enumerate(loaded.tolist()) if self._carries(marker)]
        self.markers = loaded[self.loads]
        self.points = [(k, m) for k, m in built.point_masses if self._carries(k)]

    def resultants(self, recording: Recording) -> Array:
        """Return F1 F2 F3 M1 M2 M3 (k, 6) on the face +x, in the axes of the deformed section."""
        r, A, q = body_frames(self.model, self.body, recording.y)
        place_B, turn = self._section(q)
        x = r + np.einsum("kab,kb->ka", A, place_B)
        F, M = self._inertia(recording, r, A, q, x)
        forces = recording.loads(self.loads)
        for k, marker in enumerate(self.markers.tolist()):
            arm = recording.position(marker) - x
            F += forces[:, k, :3]
            M += forces[:, k, 3:] + np.cross(arm, forces[:, k, :3])
        for marker, mass in self.points:
            weight = mass * (self.model.gravity_G - recording.acceleration(marker))
            F += weight
            M += np.cross(recording.position(marker) - x, weight)
        to_section = A @ vectors_to_matrices(turn) @ self.A_BE
        return np.concatenate([np.einsum("kba,kb->ka", to_section, each) for each in (F, M)], 1)

    def _carries(self, marker: int) -> bool:
        """Return whether a marker is on the part beyond."""
        model = self.model
        return bool(
            model.marker_body[marker] == self.body and model.marker_x[marker, 0] > self._beyond
        )

    def motion_at(self, x: Array) -> Array:
        """Return translation and rotation (p, 6, m) at places along the beam per unit mode."""
        columns = [
            [np.interp(x, self.along, shape[:, a]) for a in range(6)] for shape in self.shapes
        ]
        motion = np.array(columns).reshape(len(self.shapes), 6, len(x))
        return np.ascontiguousarray(np.moveaxis(motion, (0, 1, 2), (2, 1, 0)))

    def _slices(self, M_E: Array) -> None:
        """Set mass, mass centres, rotary inertia and motion of the slices beyond, p of them."""
        ends = np.concatenate([[self.x], self.along[self.along > self.x]])
        width = np.diff(ends)
        x = (ends[:-1, None] + width[:, None] * np.array(GAUSS)).ravel()
        length = np.repeat(0.5 * width, 2)
        if len(M_E) == 1:
            M = np.repeat(M_E, len(x), axis=0)
        else:  # an element has the section of its middle
            element = np.clip(np.searchsorted(self.along, x) - 1, 0, len(self.along) - 2)
            M = 0.5 * (M_E[element] + M_E[element + 1])
        m = np.trace(M[:, :3, :3], axis1=1, axis2=2) / 3.0
        moment = M[:, 3:, :3] / m[:, None, None]
        centre_E = np.stack([moment[:, 2, 1], moment[:, 0, 2], moment[:, 1, 0]], axis=1)
        cross = np.array([skew(c) for c in centre_E]).reshape(-1, 3, 3)
        J_E = M[:, 3:, 3:] + m[:, None, None] * cross @ cross
        offset_B = centre_E @ self.A_BE.T
        motion = self.motion_at(x)
        turned = np.array([skew(c) for c in offset_B]).reshape(-1, 3, 3)
        self.mass = m * length
        self.place_B = self.nodes[0] + x[:, None] * np.array([1.0, 0.0, 0.0]) + offset_B
        self.phi = motion[:, :3] - turned @ motion[:, 3:]
        self.psi = motion[:, 3:]
        self.J_B = length[:, None, None] * (self.A_BE @ J_E @ self.A_BE.T)

    def _section(self, q: Array) -> tuple[Array, Array]:
        """Return place (k, 3) and rotation vector (k, 3) of the section in the body."""
        motion = self.motion_at(np.array([self.x]))[0]
        start = self.nodes[0] + np.array([self.x, 0.0, 0.0])
        place = start + q @ motion[:3].T
        if stiffened(self.model, self.body):  # a bent line is shorter along x
            ends = np.append(self.along[self.along < self.x], self.x)
            moved = np.einsum("pam,km->kpa", self.motion_at(ends)[:, 1:3], q)
            if len(ends) > 1:
                place[:, 0] -= 0.5 * (np.diff(moved, axis=1) ** 2 / np.diff(ends)[:, None]).sum(
                    axis=(1, 2)
                )
        return place, q @ motion[3:].T

    def _inertia(
        self, recording: Recording, r: Array, A: Array, q: Array, x: Array
    ) -> tuple[Array, Array]:
        """Return force and moment about x of weight and inertia of the slices, global, (k, 3)."""
        j = self.model.n_pos + int(self.model.vel_start[self.body])
        own = slice(j, j + 6 + q.shape[1])
        b, f_B, h_d = self.slice_loads(A, q, recording.y[:, own], recording.rates[:, own])
        weight = np.einsum("kab,kpb->kpa", A, f_B)
        arm = r[:, None] + np.einsum("kab,kpb->kpa", A, b) - x[:, None]
        moment = np.cross(arm, weight).sum(axis=1) - np.einsum("kab,kpb->ka", A, h_d)
        return weight.sum(axis=1), moment

    def slice_loads(
        self, A: Array, q: Array, velocity: Array, rate: Array
    ) -> tuple[Array, Array, Array]:
        """Return place, weight less m a, and dh/dt of each slice, in body axes, (k, p, 3).

        Of velocity and acceleration (k, 6 + m) of the frame and the modes.

        Parameters
        ----------
        A : rotation matrices of the frame (k, 3, 3)
        q : modal coordinates (k, m)
        velocity : velocities of frame and modes (k, 6 + m)
        rate : accelerations of frame and modes (k, 6 + m)
        """
        w, w_d = velocity[:, None, 3:6], rate[:, None, 3:6]

        def moved(shapes: Array, amounts: Array) -> Array:
            return np.einsum("pam,km->kpa", shapes, amounts)

        b = self.place_B + moved(self.phi, q)
        b_d, b_dd = moved(self.phi, velocity[:, 6:]), moved(self.phi, rate[:, 6:])
        a_B = b_dd + np.cross(w_d, b) + np.cross(w, np.cross(w, b)) + 2.0 * np.cross(w, b_d)
        fall_B = np.einsum("kba,kb->ka", A, self.model.gravity_G - rate[:, :3])
        own = moved(self.psi, velocity[:, 6:])
        W = w + own
        W_d = w_d + moved(self.psi, rate[:, 6:]) + np.cross(w, own)
        J = self.J_B
        h_d = np.einsum("pab,kpb->kpa", J, W_d) + np.cross(W, np.einsum("pab,kpb->kpa", J, W))
        return b, self.mass[:, None] * (fall_B[:, None] - a_B), h_d


def resultant_values(
    key: str, built: BuiltMechanism, body: int, package: ModalPackage, signal: "ResultantSignal"
) -> Values:
    """Return what gives a resultant (k,) [N or N m].

    Parameters
    ----------
    key : key of the case file, for messages
    built : the built mechanism
    body : number of the body
    package : its modal package
    signal : table of the signal

    Raises
    ------
    InputError
        A package without resultants, a position outside its stations; `key` is that of the case.
    """
    _, forces = _forces(key, built, body, package, signal)
    row = RESULTANTS.index(signal.component)
    return lambda recording: forces(recording)[:, row]


def ply_stress_values(
    key: str, built: BuiltMechanism, body: int, package: ModalPackage, signal: "PlyStressSignal"
) -> tuple[Values, Look]:
    """Return what gives a stress (k,) in ply axes [Pa], and what looks at all times before.

    Parameters
    ----------
    key : key of the case file, for messages
    built : the built mechanism
    body : number of the body
    package : its modal package
    signal : table of the signal

    Raises
    ------
    InputError
        See `resultant_values`; also a section without stresses, or an unknown region or ply.
    """
    section, forces = _forces(key, built, body, package, signal)
    recovery = package.sections[section].recovery
    if recovery is None:
        name = package.sections[section].name
        raise InputError(f"{key}: section {name} of {package.body} has no recovery of stresses")
    points = _points(key, recovery, signal)
    component = STRESSES.index(signal.component)
    rows = unit_stress_M(recovery, points)[:, component]  # (p, 6)

    own = object()

    def look(recording: Recording) -> None:
        highest = np.abs(forces(recording) @ rows.T).max(axis=0)
        recording.memory[own] = np.maximum(recording.memory.get(own, 0.0), highest)

    def values(recording: Recording) -> Array:
        if own not in recording.memory:
            look(recording)
        return forces(recording) @ rows[int(np.argmax(recording.memory[own]))]

    return values, look


def _forces(
    key: str,
    built: BuiltMechanism,
    body: int,
    package: ModalPackage,
    signal: "ResultantSignal | PlyStressSignal",
) -> tuple[int, Values]:
    """Return the section at x, and what gives the resultants (k, 6) there."""
    (section, at), own = resultants_at(key, package, signal.x), object()
    if signal.method == "equilibrium":
        cut = Cut(key, built, body, package, signal.x)
        return section, lambda recording: recording.once(own, lambda: cut.resultants(recording))
    return section, lambda recording: recording.once(own, lambda: recording.modes(body) @ at.T)


def resultants_at(key: str, package: ModalPackage, x: float) -> tuple[int, Array]:
    """Return the section at x and the resultants (6, m) there per unit mode.

    They are linear between stations. If two stations have the same position, those of the far
    side are used.

    Parameters
    ----------
    key : key of the case file, for messages
    package : modal package of the body
    x : position along the body [m]

    Raises
    ------
    InputError
        A package without resultants, a position outside its stations; `key` is that of the case.
    """
    recovery: BodyRecovery | None = package.recovery
    if recovery is None:
        raise InputError(f"{key}: the package of {package.body} has no recovery of resultants")
    stations = recovery.station_x
    if not stations[0] - 1e-9 <= x <= stations[-1] + 1e-9:
        raise InputError(
            f"{key}.x = {x:g}: expected {stations[0]:g} to {stations[-1]:g} m, the stations of "
            f"{package.body}"
        )
    last = int(np.searchsorted(stations, x + 1e-9, side="right")) - 1
    last = min(max(last, 0), len(stations) - 2)
    gap = stations[last + 1] - stations[last]
    share = min(max((x - stations[last]) / gap, 0.0), 1.0) if gap > 0.0 else 1.0
    F = recovery.resultants_E
    return int(recovery.section[last]), (1.0 - share) * F[last] + share * F[last + 1]


def _points(key: str, recovery: SectionRecovery, signal: "PlyStressSignal") -> IntArray:
    """Return the rows of the points of a ply: all, or the one nearest to `point`."""
    regions = list(dict.fromkeys(ply.region for ply in recovery.plies))
    region = signal.region
    if region is None:
        if len(regions) > 1:
            raise InputError(f"{key}.region: missing; expected one of {few(regions)}")
        region = regions[0]
    if region not in regions:
        raise InputError(f'{key}.region = "{region}": no such region{nearest(region, regions)}')
    numbers = {p.index: k for k, p in enumerate(recovery.plies) if p.region == region}
    if signal.ply not in numbers:
        raise InputError(
            f"{key}.ply = {signal.ply}: expected 0 to {max(numbers)}, the plies of {region}"
        )
    points = np.flatnonzero(recovery.ply == numbers[signal.ply])
    if signal.point is not None:
        away = np.linalg.norm(recovery.points[points] - np.array(signal.point), axis=1)
        points = points[[int(np.argmin(away))]]
    return points


if TYPE_CHECKING:
    from ..inputs.case.tables.signals import PlyStressSignal
    from ..inputs.common.materials import IsotropicMaterial, OrthotropicMaterial

    Materials = Mapping[str, IsotropicMaterial | OrthotropicMaterial]

_LINES = {"11": "fibre", "22": "transverse", "33": "transverse"}


def stress_life(
    materials: "Materials", package: ModalPackage, signal: "PlyStressSignal"
) -> StressLife | None:
    """Return the S-N line of a stress; None if the case has none for it.

    Parameters
    ----------
    materials : materials of the case, with their S-N lines
    package : modal package of the body
    signal : table of the signal

    Raises
    ------
    InputError
        Cycles cannot be counted: a package is missing.
    """
    plies = [
        ply for section in package.sections if section.recovery for ply in section.recovery.plies
    ]
    own = [ply for ply in plies if signal.region in (None, ply.region)]
    named = {ply.material for ply in own if ply.index == signal.ply}
    for name in sorted(named & set(materials)):
        material, line = materials[name], None
        if material.kind == "isotropic":
            line = material.fatigue
        elif material.fatigue is not None:
            line = getattr(material.fatigue, _LINES.get(signal.component, "shear"))
        if line is not None:
            check_rainflow(f"materials.{name}.fatigue")
            return StressLife(
                np.array(line.amplitude),
                np.array(line.cycles),
                line.ultimate or np.inf,
                line.limit or 0.0,
            )
    return None
