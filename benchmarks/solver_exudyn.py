"""The benchmarks' mechanisms in Exudyn, from the same modal packages.

Bodies are ObjectFFRFreducedOrder with the package's modes, masses and stiffness; point masses on
interfaces are added to the body's own sums, which saves Exudyn their coordinates. Rigid frames use
Cardan angles, so that no normalising constraint is needed; the drive is a constraint on the
velocity of one coordinate, so that no Python function is called inside a step. `make bench`
installs Exudyn into build/peers (extra `peers`); the module without range checks is loaded.
"""

import contextlib
import io
import os
import sys
import time
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from solver_problems import EIGHT, GRAVITY, interface

from plymotion.solver.math.arrays import Array
from plymotion.solver.math.rotations import skew
from plymotion.solver.package import ModalPackage, read_package

PEERS = Path(os.environ.get("PLYMOTION_PEERS", "build/peers"))
SPECTRAL_RADIUS = 0.8
# Newton's iteration with a new Jacobian in every iteration is Exudyn's default; keeping it until
# convergence slows down gives the same errors in three fifths of the time.
FULL, MODIFIED = "full Newton", "modified Newton"


@dataclass(frozen=True)
class Sums:
    """Inertia of a reduced body with the point masses that it carries."""

    mass: float
    S0: Array  # (3,)
    T00: Array  # (3, 3)
    S: Array  # (3, m)
    T01: Array  # (3, 3, m)
    T11: Array  # (3, 3, m, m)
    M_qq: Array  # (m, m)


def exudyn() -> tuple[Any, Any]:
    """Exudyn without range checks, and its item classes. Raises SystemExit without it."""
    sys.path.insert(0, str(PEERS))
    sys.exudynFast = True  # type: ignore[attr-defined]  # read by Exudyn when it is imported
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            import exudyn as exu
            from exudyn import itemInterface
    except ImportError as error:
        raise SystemExit(f"{PEERS}: no Exudyn ({error}): `make bench` installs it") from error
    finally:
        sys.path.remove(str(PEERS))
    if "exudyn.exudynCPPfast" not in sys.modules:
        print("note: this processor has no AVX2; Exudyn runs with range checks", file=sys.stderr)
    return exu, itemInterface


def carrying(package: ModalPackage, masses: dict[str, float]) -> Sums:
    """Sums of a package with point masses (interface -> kg) added to them."""
    i = package.invariants
    mass, S0, T00, S, T01, T11 = i.mass, i.S0_B, i.T00_B, i.S_B, i.T01_B, i.T11_B
    M_qq = package.mass
    for name, m in masses.items():
        at = interface(package, name)
        x, phi = at.position_B, at.phi_B
        mass, S0, T00 = mass + m, S0 + m * x, T00 + m * np.outer(x, x)
        S, M_qq = S + m * phi, M_qq + m * phi.T @ phi
        T01 = T01 + m * np.einsum("a,bi->abi", x, phi)
        T11 = T11 + m * np.einsum("ai,bj->abij", phi, phi)
    return Sums(mass, S0, T00, S, T01, T11, M_qq)


class Plane:
    """A mechanism of reduced bodies in the plane x, y, as items are added."""

    def __init__(self, gravity: str = "nodes") -> None:
        self.exu, self.items = exudyn()
        self.container = self.exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.gravity = gravity
        ground = self.mbs.AddObject(self.items.ObjectGround())
        self.ground = self.mbs.AddMarker(self.items.MarkerBodyRigid(bodyNumber=ground))
        fixed = self.mbs.AddNode(self.items.NodePointGround())
        self.fixed = self.mbs.AddMarker(
            self.items.MarkerNodeCoordinate(nodeNumber=fixed, coordinate=0)
        )

    def _matrix(self, values: Array) -> Any:
        container = self.exu.MatrixContainer()
        container.SetWithDenseMatrix(values, useDenseMatrix=True)
        return container

    def body(
        self,
        package: ModalPackage,
        place: tuple[float, float],
        *,
        spin: float = 0.0,
        velocity_y: float = 0.0,
        masses: dict[str, float] | None = None,
        g: float = -GRAVITY[1],
        tilt: float = 0.0,
        modal_rates: Array | None = None,
    ) -> tuple[int, int]:
        """Add a reduced body; return the numbers of its frame's node and of its object.

        Its frame is turned about x by `tilt` [rad]; modes start with `modal_rates` (m,).
        """
        items, mbs, m = self.items, self.mbs, package.n_mode
        sums = carrying(package, masses or {})
        frame = mbs.AddNode(
            items.NodeRigidBodyRxyz(
                referenceCoordinates=[*place, 0, tilt, 0, 0],
                initialVelocities=[0, velocity_y, 0, 0, 0, spin],
            )
        )
        modal = mbs.AddNode(
            items.NodeGenericODE2(
                numberOfODE2Coordinates=m,
                referenceCoordinates=[0] * m,
                initialCoordinates=[0] * m,
                initialCoordinates_t=[0] * m if modal_rates is None else modal_rates.tolist(),
            )
        )
        eye, eps = np.eye(3), _permutations()
        T01, T11 = sums.T01, sums.T11
        found = mbs.AddObject(
            items.ObjectFFRFreducedOrder(
                nodeNumbers=[frame, modal],
                massMatrixReduced=self._matrix(sums.M_qq),
                stiffnessMatrixReduced=self._matrix(package.stiffness),
                modeBasis=package.shapes_B[:, :, :3].reshape(m, -1).T.copy(),
                referencePositions=package.nodes_B.ravel(),
                mass=sums.mass,
                inertia=np.trace(sums.T00) * eye - sums.T00 + package.invariants.J0_B,
                centerOfMass=sums.S0 / sums.mass,
                mPhitTPsi=sums.S,
                mPhitTPsiTilde=np.hstack([skew(sums.S[:, i].copy()) for i in range(m)]),
                mXRefTildePsi=-(np.einsum("abc,abi->ci", eps, T01) + package.invariants.J_psi_B),
                mPsiTildePsi=-np.einsum("abc,abij->icj", eps, T11).reshape(3 * m, m),
                mXRefTildePsiTilde=np.hstack(
                    [np.trace(T01[..., i]) * eye - T01[..., i].T for i in range(m)]
                ),
                mPsiTildePsiTilde=np.block(
                    [
                        [np.trace(T11[..., i, j]) * eye - T11[..., i, j].T for j in range(m)]
                        for i in range(m)
                    ]
                ),
                visualization=items.VObjectFFRFreducedOrder(show=False),
            )
        )
        self._weight(found, package, masses or {}, sums.mass, g)
        return frame, found

    def _weight(
        self, body: int, package: ModalPackage, masses: dict[str, float], total: float, g: float
    ) -> None:
        """Gravity: on the nodes where they are, or as Exudyn does it, on the rigid body."""
        if self.gravity == "body":
            marker = self.mbs.AddMarker(self.items.MarkerBodyMass(bodyNumber=body))
            self.mbs.AddLoad(
                self.items.LoadMassProportional(markerNumber=marker, loadVector=[0, -g, 0])
            )
            return
        weights = package.node_mass.copy()
        for name, m in masses.items():
            weights[node(package, name)] += m
        marker = self.mbs.AddMarker(
            self.items.MarkerSuperElementPosition(
                bodyNumber=body,
                meshNodeNumbers=list(range(weights.size)),
                weightingFactors=weights / weights.sum(),
            )
        )
        self.mbs.AddLoad(
            self.items.LoadForceVector(markerNumber=marker, loadVector=[0, -g * total, 0])
        )

    def hinge(self, marker: int, frame: int) -> None:
        """Pin a body's frame to a position marker; its z axis stays that of the ground."""
        items, mbs = self.items, self.mbs
        other = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=frame))
        mbs.AddObject(items.ObjectJointSpherical(markerNumbers=[marker, other]))
        axes = [0, 0, 0, 1, 1, 0]
        mbs.AddObject(
            items.ObjectJointGeneric(markerNumbers=[self.ground, other], constrainedAxes=axes)
        )

    def drive(self, frame: int, speed: float) -> None:
        """Hold a frame in place and turn it about z at constant speed."""
        for k in range(6):
            marker = self.mbs.AddMarker(
                self.items.MarkerNodeCoordinate(nodeNumber=frame, coordinate=k)
            )
            turning = k == 5
            self.mbs.AddObject(
                self.items.ObjectConnectorCoordinate(
                    markerNumbers=[self.fixed, marker],
                    velocityLevel=turning,
                    offset=speed if turning else 0.0,
                )
            )

    def at_interface(self, body: int, package: ModalPackage, name: str = "tip") -> int:
        """Marker at an interface of a body."""
        return int(
            self.mbs.AddMarker(
                self.items.MarkerSuperElementPosition(
                    bodyNumber=body, meshNodeNumbers=[node(package, name)], weightingFactors=[1.0]
                )
            )
        )

    def sensor(self, body: int, package: ModalPackage) -> int:
        """Sensor of the position of a body's tip, and the end of building."""
        found = self.mbs.AddSensor(
            self.items.SensorSuperElement(
                bodyNumber=body,
                meshNodeNumber=node(package, "tip"),
                outputVariableType=self.exu.OutputVariableType.Position,
                storeInternal=True,
                writeToFile=False,
            )
        )
        self.mbs.Assemble()
        return int(found)

    def solve(
        self, sensor: int, t_end: float, steps: int, newton: str, *, sparse: bool = False
    ) -> tuple[Array, float]:
        """Generalized-alpha; positions (k, 3) of the sensor and the processor time [s]."""
        settings = self.exu.SimulationSettings()
        scheme = settings.timeIntegration
        scheme.endTime, scheme.numberOfSteps, scheme.verboseMode = t_end, steps, 0
        scheme.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
        scheme.newton.useModifiedNewton = newton == MODIFIED
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = 0.01
        settings.parallel.numberOfThreads = 1
        kinds = self.exu.LinearSolverType
        settings.linearSolver.solverType = kinds.EigenSparse if sparse else kinds.EXUdense
        begin = time.process_time()
        self.mbs.SolveDynamic(settings)
        cpu = time.process_time() - begin
        return self.mbs.GetSensorStoredData(sensor)[:, 1:4], cpu


def double_pendulum(
    steps: int, newton: str, *, gravity: str = "nodes", g: float = -GRAVITY[1], t_end: float = 1.0
) -> tuple[Array, float]:
    """Tip (k, 3) of the double pendulum every 0.01 s, and the processor time [s]."""
    arm, hand = (read_package(EIGHT / f"{body}.vtkhdf") for body in ("arm", "hand"))
    plane, speed = Plane(gravity), 20.0
    elbow = float(interface(arm, "tip").position_B[0])
    frame, body = plane.body(arm, (0.0, 0.0), spin=speed, masses={"tip": 1.0}, g=g)
    plane.drive(frame, speed)
    other, last = plane.body(hand, (elbow, 0.0), velocity_y=speed * elbow, masses={"tip": 3.0}, g=g)
    plane.hinge(plane.at_interface(body, arm), other)
    return plane.solve(plane.sensor(last, hand), t_end, steps, newton)


def chain(n: int, steps: int, h: float, newton: str) -> tuple[Array, float]:
    """Chain of n links: path of its end and the processor time [s], sparse solver if it is long."""
    link = read_package(EIGHT / "hand.vtkhdf")
    length = float(interface(link, "tip").position_B[0])
    plane = Plane()
    bodies = [plane.body(link, (i * length, 0.0)) for i in range(n)]
    plane.hinge(plane.ground, bodies[0][0])
    for (_, before), (frame, _) in pairwise(bodies):
        plane.hinge(plane.at_interface(before, link), frame)
    sensor = plane.sensor(bodies[-1][1], link)
    return plane.solve(sensor, steps * h, steps, newton, sparse=n > 4)


def node(package: ModalPackage, name: str) -> int:
    """Row of the node at an interface."""
    away = np.linalg.norm(package.nodes_B - interface(package, name).position_B, axis=1)
    return int(np.argmin(away))


def _permutations() -> Array:
    eps = np.zeros((3, 3, 3))
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        eps[a, b, c], eps[b, a, c] = 1.0, -1.0
    return eps
