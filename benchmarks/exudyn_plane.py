"""A plane mechanism of reduced bodies in Exudyn. Imports NumPy and Exudyn only.

Bodies are ObjectFFRFreducedOrder. Rigid frames use Cardan angles, so that no normalising constraint
is needed; the drive is a constraint on the velocity of one coordinate, so that no Python function
is called inside a step. `make bench` installs Exudyn into build/peers (extra `peers`); the module
without range checks is loaded.
"""

import contextlib
import io
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PEERS = Path(os.environ.get("PLYMOTION_PEERS", "build/peers"))
SPECTRAL_RADIUS = 0.8
# Newton's iteration with a new Jacobian in every iteration is Exudyn's default; keeping it until
# convergence slows down gives the same errors in three fifths of the time.
FULL, MODIFIED = "full Newton", "modified Newton"


@dataclass(frozen=True)
class Reduced:
    """A reduced body with n nodes and m modes, in the arrays of ObjectFFRFreducedOrder."""

    mass: float
    inertia: Array  # (3, 3) about the origin of the frame
    centre: Array  # (3,) of mass
    nodes: Array  # (n, 3)
    basis: Array  # (3 n, m)
    M_qq: Array  # (m, m)
    K_qq: Array  # (m, m)
    mPhitTPsi: Array  # (3, m)
    mPhitTPsiTilde: Array  # (3, 3 m)
    mXRefTildePsi: Array  # (3, m)
    mPsiTildePsi: Array  # (3 m, m)
    mXRefTildePsiTilde: Array  # (3, 3 m)
    mPsiTildePsiTilde: Array  # (3 m, 3 m)
    weights: Array  # (n,) share of each node in the mass
    tip: int  # node


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
        reduced: Reduced,
        place: tuple[float, float],
        *,
        spin: float = 0.0,
        velocity_y: float = 0.0,
        g: float = 9.81,
        tilt: float = 0.0,
        modal_rates: Array | None = None,
    ) -> tuple[int, int]:
        """Add a reduced body; return the numbers of its frame's node and of its object.

        Its frame is turned about x by `tilt` [rad]; modes start with `modal_rates` (m,).
        """
        items, mbs, m = self.items, self.mbs, len(reduced.M_qq)
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
        found = mbs.AddObject(
            items.ObjectFFRFreducedOrder(
                nodeNumbers=[frame, modal],
                massMatrixReduced=self._matrix(reduced.M_qq),
                stiffnessMatrixReduced=self._matrix(reduced.K_qq),
                modeBasis=reduced.basis,
                referencePositions=reduced.nodes.ravel(),
                mass=reduced.mass,
                inertia=reduced.inertia,
                centerOfMass=reduced.centre,
                mPhitTPsi=reduced.mPhitTPsi,
                mPhitTPsiTilde=reduced.mPhitTPsiTilde,
                mXRefTildePsi=reduced.mXRefTildePsi,
                mPsiTildePsi=reduced.mPsiTildePsi,
                mXRefTildePsiTilde=reduced.mXRefTildePsiTilde,
                mPsiTildePsiTilde=reduced.mPsiTildePsiTilde,
                visualization=items.VObjectFFRFreducedOrder(show=False),
            )
        )
        self._weight(found, reduced, g)
        return frame, found

    def _weight(self, body: int, reduced: Reduced, g: float) -> None:
        """Gravity: on the nodes where they are, or as Exudyn does it, on the rigid body."""
        if self.gravity == "body":
            marker = self.mbs.AddMarker(self.items.MarkerBodyMass(bodyNumber=body))
            self.mbs.AddLoad(
                self.items.LoadMassProportional(markerNumber=marker, loadVector=[0, -g, 0])
            )
            return
        marker = self.mbs.AddMarker(
            self.items.MarkerSuperElementPosition(
                bodyNumber=body,
                meshNodeNumbers=list(range(len(reduced.weights))),
                weightingFactors=reduced.weights,
            )
        )
        self.mbs.AddLoad(
            self.items.LoadForceVector(markerNumber=marker, loadVector=[0, -g * reduced.mass, 0])
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

    def at_node(self, body: int, number: int) -> int:
        """Marker at a node of a body."""
        return int(
            self.mbs.AddMarker(
                self.items.MarkerSuperElementPosition(
                    bodyNumber=body, meshNodeNumbers=[number], weightingFactors=[1.0]
                )
            )
        )

    def sensor(self, body: int, number: int, file: str = "") -> int:
        """Sensor of the position of a node of a body, and the end of building."""
        found = self.mbs.AddSensor(
            self.items.SensorSuperElement(
                bodyNumber=body,
                meshNodeNumber=number,
                outputVariableType=self.exu.OutputVariableType.Position,
                storeInternal=not file,
                writeToFile=bool(file),
                fileName=file,
            )
        )
        self.mbs.Assemble()
        return int(found)

    def solve(
        self,
        t_end: float,
        steps: int,
        newton: str,
        *,
        sparse: bool = False,
        every: float = 0.01,
        file: str = "",
    ) -> float:
        """Generalized-alpha; the processor time [s]. Sensors see the motion `every` seconds.

        With `file`, all coordinates are written into it, as often.
        """
        settings = self.exu.SimulationSettings()
        scheme = settings.timeIntegration
        scheme.endTime, scheme.numberOfSteps, scheme.verboseMode = t_end, steps, 0
        scheme.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
        scheme.newton.useModifiedNewton = newton == MODIFIED
        # Exudyn sums its steps, and rounding would make some outputs late by one of them.
        every *= 1.0 - 1e-7
        solution = settings.solution
        solution.file.writePeriod = every
        solution.file.write, solution.sensors.writePeriod = bool(file), every
        if file:
            solution.file.name = file
        settings.parallel.numberOfThreads = 1
        kinds = self.exu.LinearSolverType
        settings.linearSolver.solverType = kinds.EigenSparse if sparse else kinds.EXUdense
        begin = time.process_time()
        self.mbs.SolveDynamic(settings)
        return time.process_time() - begin

    def path(self, sensor: int) -> Array:
        """Positions (k, 3) that a sensor has stored."""
        return np.asarray(self.mbs.GetSensorStoredData(sensor)[:, 1:4])


def double_pendulum(
    arm: Reduced, hand: Reduced, gravity: str = "nodes", g: float = 9.81, file: str = ""
) -> tuple[Plane, int]:
    """The benchmark's double pendulum, and the sensor of its tip (into `file`, if given)."""
    plane, speed = Plane(gravity), 20.0
    elbow = float(arm.nodes[arm.tip, 0])
    frame, body = plane.body(arm, (0.0, 0.0), spin=speed, g=g)
    plane.drive(frame, speed)
    other, last = plane.body(hand, (elbow, 0.0), velocity_y=speed * elbow, g=g)
    plane.hinge(plane.at_node(body, arm.tip), other)
    return plane, plane.sensor(last, hand.tip, file)
