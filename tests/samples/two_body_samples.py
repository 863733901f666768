"""Two flexible bodies of mass points on a hinge and a ball joint, as stiff as a test wants."""

import numpy as np
from samples.flexible_samples import Points, body_of, random_points
from samples.mechanism_samples import GRAVITY, GROUND, Rods, Sample

from plymotion.solver.math.laws import Law, polynomial
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.tables import ForceTable, JointTable, MarkerTable

N_MODE = 2


def two_bodies(
    stiffness: float | None,
    damping: float = 0.0,
    drive: Law | None = None,
    forces: tuple[ForceTable, ...] = (),
    gravity: tuple[float, float, float] = GRAVITY,
) -> Sample:
    """Two flexible bodies that swing from rest.

    Markers: 0 ground, 1 and 2 at the ends of the first body, 3 and 4 at those of the second.

    Parameters
    ----------
    stiffness : of the first mode, half of the second's [1/s2 times modal mass]; None: rigid
    damping : of the modes, [1/s times modal mass]
    drive : of the first body's angle
    forces : between markers
    """
    rng = np.random.default_rng(11)
    m = 0 if stiffness is None else N_MODE
    shapes = rng.normal(size=(2, 2, 3, N_MODE))
    points = [random_points(rng, N_MODE) for _ in range(2)]
    bodies = [_body(p, stiffness, damping) for p in points]
    end = np.array([1.0, 0.3, -0.2])
    markers = [MarkerTable(GROUND, np.zeros(3))]
    for k in range(2):
        for x, size in ((np.zeros(3), 0.0), (end, 0.2)):
            phi, psi = size * shapes[k, :, :, :m]
            markers.append(MarkerTable(k, x, np.eye(3), phi, psi))
    joints = [JointTable("foot", "revolute", 0, 1), JointTable("ball", "spherical", 2, 3)]
    if drive is not None:
        joints.append(JointTable("drive", "rotation_drive", 0, 1, drive))
    model = assemble_model(bodies, markers, joints, gravity_G=gravity, forces=forces)
    positions = np.zeros(model.n_pos)
    second = int(model.pos_start[1])
    positions[3] = positions[second + 3] = 1.0
    positions[second : second + 3] = end
    none = np.zeros(model.n_vel)
    return Sample(model, Start(positions, none, none.astype(bool)), [j.name for j in joints], 4)


def _body(points: Points, stiffness: float | None, damping: float):
    if stiffness is None:
        none = np.zeros((points.x.shape[0], 3, 0))
        return body_of(Points(points.m, points.x, none, none, points.J))
    body = body_of(points, stiffness)
    return body._replace(damping=damping * body.mass)


def torn() -> Sample:
    """A rod on a hinge whose tip is held by a distance and whose angle is driven: at rest at t = 0
    only both can be.
    """
    rods = Rods(side=0.1)
    rod = rods.rod((0, 0, 0), (1, 0, 0))
    rods.joint("foot", "revolute", GROUND, rod, (0, 0, 0))
    ends = rods.marker(GROUND, (1, 1, 0)), rods.marker(rod, (1, 0, 0))
    rods.joints.append(JointTable("held", "distance", *ends, parameters=(1.0,)))
    ends = rods.marker(GROUND, (0, 0, 0)), rods.marker(rod, (0, 0, 0))
    drive = polynomial([0.0, 0.0, 0.0, 5.0])
    rods.joints.append(JointTable("drive", "rotation_drive", *ends, drive))
    return rods.sample((rod, (1, 0, 0)), gravity_G=GRAVITY)


def stretching_rod(stiffness: float | None) -> Sample:
    """A mass point on a massless rod with one mode that stretches it; None: a rigid rod.

    A second mass at the hinge, and a little rotary inertia, make the mass matrix positive.
    """
    m = 0 if stiffness is None else 1
    phi, psi = np.zeros((2, 3, m)), np.zeros((2, 3, m))
    phi[1, 0, :] = 1.0
    x = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    J = np.array([1e-3 * np.eye(3)] * 2)
    body = body_of(Points(np.ones(2), x, phi, psi, J), stiffness or 0.0)
    none = np.zeros((3, m))
    markers = [MarkerTable(GROUND, np.zeros(3)), MarkerTable(0, np.zeros(3), np.eye(3), none, none)]
    joints = [JointTable("foot", "revolute", 0, 1)]
    model = assemble_model([body], markers, joints, gravity_G=GRAVITY)
    positions, rest = np.zeros(model.n_pos), np.zeros(model.n_vel)
    positions[3] = 1.0
    return Sample(model, Start(positions, rest, rest.astype(bool)), ["foot"], 1)
