"""Joint coordinates of a tree: states from them, mass matrix, bias forces and Jacobians by them.

A mechanism has absolute coordinates with constraints. With the rates xdot of the joint coordinates
and rows G that measure them, the velocities v of all bodies solve

    [Phi_q; G] v = [0; xdot],    v = Z xdot,    [Phi_q; G] a = [gamma; gamma_G + xddot].

Then M a - f = 0, projected by Z', is M_x xddot + c = tau with M_x = Z' M Z and c = Z' (M a_0 - f),
a_0 the accelerations at xddot = 0. G are the rows of the joints' drives, so that nothing here
repeats a joint. A body that no joint ties to the ground has the motion of its frame as coordinates,
a flexible body its modal coordinates as well.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...math.arrays import Array
from ...math.rotations import matrix_to_parameters, matrix_to_vector, rotation_matrix
from ...math.rotations import vector_to_matrix as turn
from ..elements.floating_frame import evaluate_bodies
from ..elements.joints.contract import ANGLE, Coordinate, Displacement
from ..elements.joints.rotation_drive import rotation_drive
from ..elements.joints.rows import along_axis
from ..elements.joints.table import JOINTS, NAMES
from ..elements.marker import evaluate_markers, single_motion
from ..evaluation.accelerations import dense
from ..evaluation.evaluation import evaluate
from ..model.model import GAMMA, GROUND, N_ROW, Model, new_workspace

FRAME = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class Step:
    """A joint on the way from the ground to the bodies, or the frame of a free body.

    Attributes
    ----------
    markers : near, far; none of a free body
    turned : the near one is on the second place of the joint
    coordinates : of the second place in the first
    offset : (3,) vector from place one to two at the given start, axes of the joint [m]
    first : number of its first coordinate
    """

    body: int  # that it leads to
    markers: tuple[int, ...]
    turned: bool
    coordinates: tuple[Coordinate, ...]
    offset: Array
    first: int


@dataclass(frozen=True)
class Projected:
    """Equations of motion in joint coordinates (n,): M xddot + c = tau.

    Attributes
    ----------
    M : (n, n) mass matrix
    c : (n,) bias: velocity terms less gravity, elastic forces and all force elements
    Z : (n_vel, n) velocities of the mechanism by the rates of the joint coordinates
    """

    M: Array
    c: Array
    Z: Array


class JointCoordinates:
    """The joint coordinates of a mechanism that is a tree; couplings and drives are left out.

    Parameters
    ----------
    model, body_names, joint_names : of the mechanism
    offsets : vector (3,) from place one to two of each joint at the given start [m]

    Attributes
    ----------
    names : of the coordinates: "JOINT.angle", "JOINT.z"; of a free body "BODY.x" to "BODY.rz",
        position and rotation vector of its frame; "BODY.q1" of a mode

    Raises
    ------
    InputError
        A joint closes a loop, or has no coordinates that determine it.
    """

    def __init__(
        self,
        model: Model,
        body_names: Sequence[str],
        joint_names: Sequence[str],
        offsets: Mapping[str, Array],
    ) -> None:
        self._model, self._work = model, new_workspace(model)
        joints = [j for j, kind in enumerate(model.joint_kind) if NAMES[kind] in JOINTS]
        self._rows = [r for j in joints for r in range(*model.joint_row[j : j + 2])]
        self.names: list[str] = []
        first: dict[int, int] = {}
        for j in joints:
            first[j] = len(self.names)
            self.names += [f"{joint_names[j]}.{c.name}" for c in self._coordinates(j, joint_names)]
        self._steps: list[Step] = []
        reached, waiting = {GROUND}, dict.fromkeys(joints)
        for body in (None, *range(model.n_body)):
            if body in reached:
                continue
            if body is not None:
                reached.add(body)
                self._steps.append(Step(body, (), False, (), np.zeros(3), len(self.names)))
                self.names += [f"{_name(body_names, body)}.{part}" for part in FRAME]
            while (following := self._next(waiting, reached, joint_names)) is not None:
                joint, turned = following
                offset = offsets.get(joint_names[joint], np.zeros(3))
                one, two = (int(k) for k in model.joint_marker[joint])
                markers, far = ((two, one), one) if turned else ((one, two), two)
                kinds = self._coordinates(joint, joint_names)
                body_ = int(model.marker_body[far])
                reached.add(body_)
                self._steps.append(Step(body_, markers, turned, kinds, offset, first[joint]))
        self._modes = [
            (int(model.pos_start[i]) + 7 + k, int(model.vel_start[i]) + 6 + k)
            for i in range(model.n_body)
            for k in range(int(model.n_mode[i]))
        ]
        self.names += [
            f"{_name(body_names, i)}.q{k + 1}"
            for i in range(model.n_body)
            for k in range(int(model.n_mode[i]))
        ]

    def _coordinates(self, joint: int, names: Sequence[str]) -> tuple[Coordinate, ...]:
        kind = JOINTS[NAMES[self._model.joint_kind[joint]]]
        known = all(c is ANGLE or isinstance(c, Displacement) for c in kind.coordinates)
        if not known or len(kind.coordinates) != 6 - len(kind.units):
            raise InputError(
                f'joints.{names[joint]}.kind = "{kind.kind}": joint coordinates are those of fixed,'
                " revolute, prismatic, cylindrical and planar joints"
            )
        return kind.coordinates

    def _next(
        self, waiting: "dict[int, None]", reached: "set[int]", names: Sequence[str]
    ) -> "tuple[int, bool] | None":
        """Return a joint from a body that was reached to another one, and whether it is turned."""
        for joint in waiting:
            one, two = (int(self._model.marker_body[k]) for k in self._model.joint_marker[joint])
            if one in reached and two in reached:
                raise InputError(
                    f"joints.{names[joint]}: closes a loop; joint coordinates are those of a tree"
                )
            if one in reached or two in reached:
                del waiting[joint]
                return joint, two in reached
        return None

    def state(self, t: float, y: Array, values: Array, rates: Array) -> Array:
        """Return the state at joint coordinates and rates (n,); other entries are those of y (m,).

        Auxiliary states that count turns have the coordinate of their joint. Rates of a free body
        are the velocity of its frame, global, and its angular velocity in body axes.

        Parameters
        ----------
        t : time [s]
        y : state whose other entries are kept (m,)
        values : joint coordinates (n,) [m, rad]
        rates : their rates (n,) [m/s, rad/s]
        """
        model, work, y = self._model, self._work, y.copy()
        r, A = np.zeros((model.n_body + 1, 3)), np.tile(np.eye(3), (model.n_body + 1, 1, 1))
        y[: model.n_pos + model.n_vel] = 0.0
        for k, (position, _) in enumerate(self._modes):
            y[position] = values[len(values) - len(self._modes) + k]
        for i in range(model.n_body):
            y[model.pos_start[i] + 3] = 1.0
        evaluate_bodies(model, work, y)
        evaluate_markers(model, work, y)  # in the axes of their bodies
        for step in self._steps:
            given = values[step.first :]
            if not step.markers:
                r[step.body], A[step.body] = given[:3], turn(given[3:6])
            else:
                d, R = self._relative(step, given)
                (x_1, A_1), (x_2, A_2) = (self._marker(k) for k in step.markers)
                near = int(model.marker_body[step.markers[0]])
                A[step.body] = A[near] @ A_1 @ R @ A_2.T
                r[step.body] = r[near] + A[near] @ (x_1 + A_1 @ d) - A[step.body] @ x_2
        for i in range(model.n_body):
            a = int(model.pos_start[i])
            y[a : a + 3], y[a + 3 : a + 7] = r[i], matrix_to_parameters(A[i])
        y[model.n_pos : model.n_pos + model.n_vel] = self.projected(t, y).Z @ rates
        quantities, first = model.quantities, model.n_pos + model.n_vel
        given_angles = {
            self._ends(step): values[k]
            for step in self._steps
            for k, c in enumerate(step.coordinates, step.first)
            if c is ANGLE
        }
        for m in np.flatnonzero(quantities.turn >= 0):
            one, two = (int(k) for k in quantities.marker[m])
            j = int(quantities.turn[m])
            y[first + j] = given_angles.get((one, two), quantities.start[j])
        return y

    def values(self, y: Array) -> tuple[Array, Array]:
        """Return joint coordinates and rates (n,) of a state; angles within half a turn."""
        evaluate_bodies(self._model, self._work, y)
        evaluate_markers(self._model, self._work, y)
        return self._read(y)

    def _read(self, y: Array) -> tuple[Array, Array]:
        """Return the same for markers that are evaluated."""
        model, values = self._model, np.zeros(len(self.names))
        v = y[model.n_pos : model.n_pos + model.n_vel]
        for step in self._steps:
            a = int(model.pos_start[step.body])
            if not step.markers:
                values[step.first : step.first + 3] = y[a : a + 3]
                vector = matrix_to_vector(rotation_matrix(y[a + 3 : a + 7]))
                values[step.first + 3 : step.first + 6] = vector
            for k, c in enumerate(step.coordinates):
                values[step.first + k] = self._measured(step, c)
        for k, (position, _) in enumerate(self._modes):
            values[len(values) - len(self._modes) + k] = y[position]
        G, _ = self._measuring(values, None)
        return values, G @ v

    def projected(self, t: float, y: Array) -> Projected:
        """Return the equations of motion at time t and state y in joint coordinates."""
        model, work = self._model, self._work
        work.multipliers[:] = 0.0
        evaluate(model, work, t, y)
        equations = dense(model, work)
        values, rates = self._read(y)
        G, gamma = self._measuring(values, rates)
        whole = np.vstack([equations.Phi_q[self._rows], G])
        right = np.zeros((len(whole), G.shape[0] + 1))
        right[len(self._rows) :, :-1] = np.eye(G.shape[0])
        right[:, -1] = np.concatenate([equations.gamma[self._rows], gamma])
        solution = np.linalg.solve(whole, right)
        Z, a = solution[:, :-1], solution[:, -1]
        c = Z.T @ (equations.M @ a - equations.f)
        return Projected(Z.T @ equations.M @ Z, c, Z)

    def jacobian(self, t: float, y: Array, marker: int) -> Array:
        """Return velocity and angular velocity of a marker by the rates, (6, n), global.

        Parameters
        ----------
        t : time [s]
        y : state (n,), as in dynamics/model/model.py
        marker : number of the marker
        """
        Z = self.projected(t, y).Z
        return np.asarray(self._spread(marker, single_motion(self._model, marker, y)[1]) @ Z)

    def _marker(self, k: int) -> tuple[Array, Array]:
        row = self._work.motion[k]
        return row[:3].copy(), row[3:12].reshape(3, 3).copy()

    def _spread(self, k: int, J: Array) -> Array:
        """Return a Jacobian (p, n) of marker k by the velocities (n_vel,) of all bodies."""
        model, body = self._model, int(self._model.marker_body[k])
        out = np.zeros((len(J), model.n_vel))
        if body != GROUND:
            j, size = int(model.vel_start[body]), 6 + int(model.n_mode[body])
            out[:, j : j + size] = J[:, :size]
        return out

    def _relative(self, step: Step, values: Array) -> tuple[Array, Array]:
        """Return place and axes of the far marker in the near one."""
        d, R = step.offset.copy(), np.eye(3)
        for c, value in zip(step.coordinates, values, strict=False):
            if isinstance(c, Displacement):
                d[c.axis] += value
            else:
                R = turn(np.array([0.0, 0.0, value]))
        return (-R.T @ d, R.T) if step.turned else (d, R)

    def _ends(self, step: Step) -> tuple[int, int]:
        """Return the markers on the first and second place."""
        near, far = step.markers
        return (far, near) if step.turned else (near, far)

    def _measured(self, step: Step, c: Coordinate) -> float:
        (x_1, A_1), (x_2, A_2) = (self._marker(k) for k in self._ends(step))
        if isinstance(c, Displacement):
            return float(A_1[:, c.axis] @ (x_2 - x_1) - step.offset[c.axis])
        return float(np.arctan2(A_1[:, 1] @ A_2[:, 0], A_1[:, 0] @ A_2[:, 0]))

    def _measuring(self, values: Array, rates: "Array | None") -> tuple[Array, Array]:
        """Return G (n, n_vel) and gamma_G (n,) at these coordinates and rates."""
        model, work, n = self._model, self._work, len(self.names)
        G, gamma, rows = np.zeros((n, model.n_vel)), np.zeros(n), np.zeros((1, N_ROW))
        for step in self._steps:
            if not step.markers:
                j = int(model.vel_start[step.body])
                G[step.first : step.first + 6, j : j + 6] = np.eye(6)
                continue
            markers = self._ends(step)
            one, two = (work.motion[k] for k in markers)
            for i, c in enumerate(step.coordinates, step.first):
                rate = 0.0 if rates is None else float(rates[i])
                if isinstance(c, Displacement):
                    at = float(values[i] + step.offset[c.axis])
                    along_axis(rows, 0, one, two, c.axis, at, rate, 0.0)
                else:
                    rotation_drive(rows, 0, one, two, float(values[i]), rate, 0.0)
                for side, k in enumerate(markers):
                    C = rows[:, 6 * side : 6 * side + 6]
                    G[i] += self._spread(k, C @ work.J_m[k])[0]
                gamma[i] = rows[0, GAMMA]
        for k, (_, velocity) in enumerate(self._modes):
            G[n - len(self._modes) + k, velocity] = 1.0
        return G, gamma


def _name(names: Sequence[str], body: int) -> str:
    return names[body] if body < len(names) else f"virtual{body}"
