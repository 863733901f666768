"""The benchmarks' actuated beam in Exudyn: our axes x, z, -y are its X, Y, Z.

So crank and link turn about Z, far from where Cardan angles are singular.
"""

import numpy as np
from exudyn_plane import Plane
from solver_exudyn import reduced
from solver_problems import Problem, node

from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.math.arrays import Array
from plymotion.solver.run.preparation import prepare

BEAM, CRANK, LINK = 0, 1, 2  # bodies of the problem
TIP_MASS, SPEED, ARM = 5.0, 3.14, 0.025  # [kg], [rad/s], crank [m]
LENGTH = 0.25  # of the link [m]
TURN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # ours to Exudyn's axes


def actuated_beam(problem: Problem, steps: int, newton: str) -> tuple[Array, float]:
    """Tip (k, 3) of the beam every 0.01 s in our axes, and the processor time [s].

    `problem` is ours: inertia of crank and link, and the consistent velocities, are taken from it.
    """
    package = problem.spec.packages["beam"]
    start = prepare(problem.spec.mechanism, problem.spec.packages)
    model, y0 = start.model, start.y0
    velocities = [y0[model.n_pos + int(j) :] for j in model.vel_start]
    plane = Plane()
    frame, beam = plane.body(
        reduced(package, {"tip": TIP_MASS}),
        (0.0, 0.0),
        g=0.0,
        tilt=-0.5 * np.pi,
        modal_rates=velocities[BEAM][6 : 6 + package.n_mode],
    )
    plane.drive(frame, 0.0)
    places = [TURN @ y0[int(a) : int(a) + 3] for a in model.pos_start]
    crank, turning = _rigid(plane, model, CRANK, places[CRANK], velocities[CRANK])
    link, swinging = _rigid(plane, model, LINK, places[LINK], velocities[LINK])
    plane.drive(crank, SPEED)
    items, mbs = plane.items, plane.mbs

    def at(body: int, place: list[float]) -> int:
        marker = items.MarkerBodyPosition(bodyNumber=body, localPosition=place)
        return int(mbs.AddMarker(marker))

    plane.hinge(at(turning, [ARM, 0.0, 0.0]), link)
    ends = [at(swinging, [0.0, -LENGTH, 0.0]), plane.at_node(beam, node(package, "mid"))]
    mbs.AddObject(items.ObjectJointSpherical(markerNumbers=ends))
    sensor = plane.sensor(beam, node(package, "tip"))
    cpu = plane.solve(problem.t_end, steps, newton)
    return plane.path(sensor) @ TURN, cpu


def _rigid(plane: Plane, model: Model, body: int, place: Array, velocity: Array) -> tuple[int, int]:
    """Add a rigid body of our model; the numbers of its node and of its object."""
    mass, T00 = float(model.mass[body]), model.T00[body]
    inertia = TURN @ (np.trace(T00) * np.eye(3) - T00 + model.J0[body]) @ TURN.T
    node = plane.mbs.AddNode(
        plane.items.NodeRigidBodyRxyz(
            referenceCoordinates=[*place, 0, 0, 0],
            initialVelocities=[*(TURN @ velocity[:3]), *(TURN @ velocity[3:6])],
        )
    )
    found = plane.mbs.AddObject(
        plane.items.ObjectRigidBody(
            nodeNumber=node,
            physicsMass=mass,
            physicsCenterOfMass=TURN @ model.S0[body] / mass,
            # xx, yy, zz, yz, xz, xy about the frame's origin
            physicsInertia=inertia[[0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]],
        )
    )
    return int(node), int(found)
