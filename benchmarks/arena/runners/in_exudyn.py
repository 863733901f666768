"""Exudyn: rigid bodies and ObjectFFRFreducedOrder, joints, implicit integrators.

Its documented choices: modified Newton, spectral radius 0.8, no range checks, sparse solver for
more than a hundred coordinates, generalized-alpha or its trapezoidal index-2 form; Cardan angles
where the motion is plane, Euler parameters else.
"""

import contextlib
import io
import sys
from collections.abc import Callable
from typing import Any

import exudyn_beams
import numpy as np
from common import Sheet, Timed, main, not_mechanical

NAME = "Exudyn"
ENVIRONMENT: dict[str, Any] = {"pip": ["exudyn==1.13.6", "numpy"]}
FIXED = ("generalized-alpha", "trapezoidal-index2")  # with fixed steps
FREE = {  # translations along and rotations about the joint's own axes that are held; z is its axis
    "revolute": [1, 1, 1, 1, 1, 0],
    "prismatic": [1, 1, 0, 1, 1, 1],
    "cylindrical": [1, 1, 0, 1, 1, 0],
    "spherical": [1, 1, 1, 0, 0, 0],
    "fixed": [1, 1, 1, 1, 1, 1],
    "point_on_line": [1, 1, 0, 0, 0, 0],
}
MOST = 400_000  # steps


def cannot(sheet: Sheet) -> str:
    """Rigid and modal mechanisms, beams."""
    if "beam" in sheet:
        return ""
    forces = ("spring", "springs", "motors", "sampled", "rolling")
    found = not_mechanical(sheet, set(FREE), forces, modal=True)
    return found or str(sheet.get("data", {}).get("exudyn", ""))


def settings(sheet: Sheet) -> list[Sheet]:
    """Steps, a factor of four at a time."""
    if "beam" in sheet:
        return exudyn_beams.settings(sheet)
    first = len(sheet["times"])
    rates = [first * 4**k for k in range(9)]
    return [
        {"method": method, "steps": n}
        for method in ("generalized-alpha", "trapezoidal-index2")
        for n in rates
        if n <= MOST
    ]


def plane(sheet: Sheet) -> bool:
    """Whether all axes are z and all frames begin turned about it only."""
    axes = [j["axis"] for j in sheet["joints"] if j.get("axis") and j["kind"] != "prismatic"]
    turned = [np.array(b["rotation"])[2] for b in sheet["bodies"]]
    return (
        bool(axes)
        and all(np.allclose(np.abs(a), [0, 0, 1]) for a in axes)
        and all(np.allclose(t, [0, 0, 1]) for t in turned)
    )


def imported() -> tuple[Any, Any]:
    """Exudyn without range checks, and its items."""
    sys.exudynFast = True  # type: ignore[attr-defined]
    with contextlib.redirect_stdout(io.StringIO()):
        import exudyn as exu
        from exudyn import itemInterface as items
    return exu, items


class Mechanism:
    """Items of a sheet."""

    def __init__(self, sheet: Sheet) -> None:
        exu, items = imported()
        self.exu, self.items, self.sheet = exu, items, sheet
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.plane = plane(sheet)
        self.ground = self.mbs.AddObject(items.ObjectGround())
        fixed = self.mbs.AddNode(items.NodePointGround())
        self.fixed = self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=fixed, coordinate=0))
        self.frames: list[int] = []
        self.objects: list[int] = []
        self.coordinates = 0
        for body in sheet["bodies"]:
            self.body(body)
        for joint in sheet["joints"]:
            self.joint(joint)
        data = sheet.get("data", {})
        if "spring" in data:
            self.spring(data["spring"])
        for motor in data.get("motors", []):
            load = items.LoadTorqueVector(loadVector=[0, 0, motor["torque"]])
            load.markerNumber = self.moved(motor["joint"])[1]
            self.mbs.AddLoad(load)
        for entry in data.get("springs", []):
            self.mbs.AddObject(
                items.ObjectConnectorCoordinateSpringDamper(
                    markerNumbers=[self.fixed, self.moved(entry["joint"])[0]],
                    stiffness=entry.get("stiffness", 0.0),
                    damping=entry["damping"],
                )
            )
        if "rolling" in data:
            ends = [
                items.MarkerBodyRigid(bodyNumber=self.ground),
                items.MarkerNodeRigid(nodeNumber=self.frames[0]),
            ]
            joint = items.ObjectJointRollingDisc(
                markerNumbers=[self.mbs.AddMarker(end) for end in ends],
                discRadius=data["rolling"]["radius"],
                discAxis=data["rolling"]["axis"],
            )
            self.mbs.AddObject(joint)
        if "sampled" in data:
            self.sampled(data["sampled"])

    def matrix(self, values: Any) -> Any:
        """A dense matrix container."""
        container = self.exu.MatrixContainer()
        container.SetWithDenseMatrix(values, useDenseMatrix=True)
        return container

    def body(self, body: Sheet) -> None:
        """Add a body and its gravity."""
        items, mbs, g = self.items, self.mbs, self.sheet["gravity"]
        R, place = np.array(body["rotation"]), body["position"]
        spin = R @ np.array(body["spin_body"])
        if self.plane:
            angle = float(np.arctan2(R[1, 0], R[0, 0]))
            node = items.NodeRigidBodyRxyz(
                referenceCoordinates=[*place, 0, 0, angle],
                initialVelocities=[*body["velocity"], 0, 0, spin[2]],
            )
            self.coordinates += 6
        else:
            from exudyn.rigidBodyUtilities import (
                AngularVelocity2EulerParameters_t,
                RotationMatrix2EulerParameters,
            )

            ep = RotationMatrix2EulerParameters(R)
            node = items.NodeRigidBodyEP(
                referenceCoordinates=[*place, *ep],
                initialVelocities=[
                    *body["velocity"],
                    *AngularVelocity2EulerParameters_t(list(spin), ep),
                ],
            )
            self.coordinates += 7
        self.frames.append(mbs.AddNode(node))
        if "modal" in body:
            self.objects.append(self.modal(body, self.frames[-1]))
            return
        J = np.array(body["inertia"])
        number = mbs.AddObject(
            items.ObjectRigidBody(
                nodeNumber=self.frames[-1],
                physicsMass=body["mass"],
                physicsCenterOfMass=body["centre"],
                physicsInertia=J[[0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]],
            )
        )
        self.objects.append(number)
        if any(g):
            marker = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=number))
            mbs.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=g))

    def modal(self, body: Sheet, frame: int) -> int:
        """A reduced body; its weight acts on the nodes."""
        items, mbs = self.items, self.mbs
        with np.load(body["modal"]) as file:
            a = dict(file)
        m = len(a["M_qq"])
        self.coordinates += m
        modes = mbs.AddNode(
            items.NodeGenericODE2(
                numberOfODE2Coordinates=m,
                referenceCoordinates=[0] * m,
                initialCoordinates=body["modal_start"],
                initialCoordinates_t=body["modal_rates"],
            )
        )
        sums = ("mPhitTPsi", "mPhitTPsiTilde", "mXRefTildePsi", "mPsiTildePsi")
        sums += ("mXRefTildePsiTilde", "mPsiTildePsiTilde")
        number = mbs.AddObject(
            items.ObjectFFRFreducedOrder(
                nodeNumbers=[frame, modes],
                massMatrixReduced=self.matrix(a["M_qq"]),
                stiffnessMatrixReduced=self.matrix(a["K_qq"]),
                modeBasis=a["basis"],
                referencePositions=a["nodes"].ravel(),
                mass=float(a["mass"]),
                inertia=a["inertia"],
                centerOfMass=a["centre"],
                visualization=items.VObjectFFRFreducedOrder(show=False),
                **{key: a[key] for key in sums},
            )
        )
        if any(self.sheet["gravity"]):
            marker = mbs.AddMarker(
                items.MarkerSuperElementPosition(
                    bodyNumber=number,
                    meshNodeNumbers=list(range(len(a["weights"]))),
                    weightingFactors=a["weights"],
                )
            )
            weight = (float(a["mass"]) * np.array(self.sheet["gravity"])).tolist()
            mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=weight))
        return int(number)

    def marker(self, end: Sheet, rigid: bool) -> int:
        """Marker at an end of a joint: of a frame (`rigid`), or of a node of a modal body."""
        items, mbs, k = self.items, self.mbs, end["body"]
        if k < 0:
            kind, number = items.MarkerBodyRigid, self.ground
            return int(mbs.AddMarker(kind(bodyNumber=number, localPosition=end["point"])))
        body = self.sheet["bodies"][k]
        if "modal" in body and end["at"] in body["held"]:
            return int(mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=self.frames[k])))
        if "modal" in body and not self.plane:
            return int(
                mbs.AddMarker(
                    items.MarkerSuperElementRigid(
                        bodyNumber=self.objects[k],
                        meshNodeNumbers=body["corners"][end["at"]],
                        weightingFactors=[1.0 / 6.0] * 6,
                    )
                )
            )
        if "modal" in body:
            return int(
                mbs.AddMarker(
                    items.MarkerSuperElementPosition(
                        bodyNumber=self.objects[k],
                        meshNodeNumbers=[body["nodes"][end["at"]]],
                        weightingFactors=[1.0],
                    )
                )
            )
        kind = items.MarkerBodyRigid if rigid else items.MarkerBodyPosition
        return int(mbs.AddMarker(kind(bodyNumber=self.objects[k], localPosition=end["point"])))

    def joint(self, joint: Sheet) -> None:
        """Add a joint; its z axis is the axis, seen from both bodies."""
        items, mbs, kind = self.items, self.mbs, joint["kind"]
        ends = (joint["one"], joint["two"])
        flexible = self.plane and any(
            e["body"] >= 0
            and "modal" in self.sheet["bodies"][e["body"]]
            and e["at"] not in self.sheet["bodies"][e["body"]]["held"]
            for e in ends
        )
        if flexible and kind == "revolute":  # plane: pinned, frames stay in the plane
            markers = [self.marker(e, False) for e in ends]
            mbs.AddObject(items.ObjectJointSpherical(markerNumbers=markers))
            self.upright(ends)
        elif flexible and kind == "point_on_line":
            markers = [self.marker(e, False) for e in ends]
            for axis in ([1, 0, 0], [0, 1, 0]):
                mbs.AddObject(
                    items.ObjectJointSpherical(markerNumbers=markers, constrainedAxes=axis)
                )
        else:
            z = np.array(joint.get("axis") or [0.0, 0.0, 1.0])
            z = z / np.linalg.norm(z)
            x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
            x = x / np.linalg.norm(x)
            own = np.column_stack([x, np.cross(z, x), z])
            turn = [
                own
                if e["body"] < 0
                else np.array(self.sheet["bodies"][e["body"]]["rotation"]).T @ own
                for e in ends
            ]
            free, extra = FREE[kind], {}
            if joint.get("drive") and not self.plane:
                law, sign = self.law(joint["drive"]), 1.0 if ends[0]["body"] < 0 else -1.0
                free = [1] * 6
                extra["offsetUserFunction"] = lambda mbs, t, number, offsets: (
                    [0.0] * 5 + [sign * law(t)]
                )
            mbs.AddObject(
                items.ObjectJointGeneric(
                    markerNumbers=[self.marker(e, True) for e in ends],
                    constrainedAxes=free,
                    rotationMarker0=turn[0],
                    rotationMarker1=turn[1],
                    **extra,
                )
            )
        if joint.get("drive") and self.plane:
            self.drive(joint)

    def spring(self, spring: Sheet) -> None:
        """Spring and bristle friction on the x coordinate of a body that slides along it."""
        joint = next(j for j in self.sheet["joints"] if j["name"] == spring["joint"])
        frame = self.frames[max(joint["one"]["body"], joint["two"]["body"])]
        marker = self.mbs.AddMarker(self.items.MarkerNodeCoordinate(nodeNumber=frame, coordinate=0))
        state = self.mbs.AddNode(
            self.items.NodeGenericData(initialCoordinates=[1, 0, 0], numberOfDataCoordinates=3)
        )
        self.mbs.AddObject(
            self.items.ObjectConnectorCoordinateSpringDamperExt(
                markerNumbers=[self.fixed, marker],
                nodeNumber=state,
                stiffness=spring["stiffness"],
                offset=spring["rest"],
                fDynamicFriction=spring["coulomb"],
                stickingStiffness=1e6,
                stickingDamping=1e3,
            )
        )

    def moved(self, name: str) -> tuple[int, int]:
        """Markers of the body that a joint carries: its coordinate along the axis, its frame."""
        joint = next(j for j in self.sheet["joints"] if j["name"] == name)
        frame = self.frames[max(joint["one"]["body"], joint["two"]["body"])]
        at = int(np.argmax(np.abs(joint["axis"])))
        coordinate = self.items.MarkerNodeCoordinate(nodeNumber=frame, coordinate=at)
        rigid = self.items.MarkerNodeRigid(nodeNumber=frame)
        return int(self.mbs.AddMarker(coordinate)), int(self.mbs.AddMarker(rigid))

    def sampled(self, control: Sheet) -> None:
        """A force along a coordinate that is set before a step at each instant."""
        load = self.mbs.AddLoad(
            self.items.LoadCoordinate(markerNumber=self.moved(control["joint"])[0], load=0.0)
        )
        body = next(j for j in self.sheet["joints"] if j["name"] == control["joint"])
        node = self.frames[max(body["one"]["body"], body["two"]["body"])]
        position, state = self.exu.OutputVariableType.Displacement, {"next": 0}

        def act(mbs: Any, t: float) -> bool:
            # t is the end of a step; the load before it still counts in the mean of a step
            if t > state["next"] * control["period"] + 1e-9:
                x = mbs.GetNodeOutput(node, position)[0]
                mbs.SetLoadParameter(load, "load", control["gain"] * (control["setpoint"] - x))
                state["next"] += 1
            return True

        self.mbs.SetPreStepUserFunction(act)

    def upright(self, ends: tuple[Sheet, Sheet]) -> None:
        """Keep the z axis of the later frame that of the ground."""
        ground = self.mbs.AddMarker(self.items.MarkerBodyRigid(bodyNumber=self.ground))
        frame = self.frames[max(e["body"] for e in ends)]
        marker = self.mbs.AddMarker(self.items.MarkerNodeRigid(nodeNumber=frame))
        self.mbs.AddObject(
            self.items.ObjectJointGeneric(
                markerNumbers=[ground, marker], constrainedAxes=[0, 0, 0, 1, 1, 0]
            )
        )

    def drive(self, joint: Sheet) -> None:
        """The angle of a body that is hinged to the ground about z."""
        law = joint["drive"]
        number = max(joint["one"]["body"], joint["two"]["body"])
        marker = self.mbs.AddMarker(
            self.items.MarkerNodeCoordinate(nodeNumber=self.frames[number], coordinate=5)
        )
        sign = float(np.sign(joint["axis"][2]))
        markers = [self.fixed, marker]
        if law.get("speed") is not None:
            self.mbs.AddObject(
                self.items.ObjectConnectorCoordinate(
                    markerNumbers=markers, velocityLevel=True, offset=sign * law["speed"]
                )
            )
            return
        turn = self.law(law)
        self.mbs.AddObject(
            self.items.ObjectConnectorCoordinate(
                markerNumbers=markers,
                offsetUserFunction=lambda mbs, t, number, offset: sign * turn(t),
            )
        )

    @staticmethod
    def law(law: Sheet) -> Callable[[float], float]:
        """Angle of a drive over time [rad]."""
        if law.get("speed") is not None:
            return lambda t: float(law["speed"] * t)
        ramp = law["ramp"]
        speed, T = ramp["speed"], ramp["duration"]

        def angle(t: float) -> float:
            s = t / T
            if s >= 1.0:
                return float(speed * (t - 0.5 * T))
            if ramp["shape"] == "sine":
                return float(speed * T * (s * s / 2 + (np.cos(2 * np.pi * s) - 1) / (4 * np.pi**2)))
            return float(speed * T * (2.5 * s**4 - 3.0 * s**5 + s**6))

        return angle

    def solve(self, setting: Sheet) -> tuple[Any, float]:
        """Positions of the probe at the times of the sheet, and the CPU time of the solution."""
        exu, sheet, probe = self.exu, self.sheet, self.sheet["probe"]
        kind = exu.OutputVariableType.Position
        body = sheet["bodies"][probe["body"]]
        number = self.objects[probe["body"]]
        if "modal" in body:
            sensor = self.items.SensorSuperElement(
                bodyNumber=number,
                meshNodeNumber=body["nodes"][probe["at"]],
                outputVariableType=kind,
                storeInternal=True,
            )
        else:
            sensor = self.items.SensorBody(
                bodyNumber=number,
                localPosition=probe["point"],
                outputVariableType=kind,
                storeInternal=True,
            )
        sensor = self.mbs.AddSensor(sensor)
        self.mbs.Assemble()
        settings = exu.SimulationSettings()
        scheme = settings.timeIntegration
        # steps that end at the outputs
        outputs = len(sheet["times"])
        scheme.numberOfSteps = outputs * max(1, round(setting["steps"] / outputs))
        scheme.endTime, scheme.verboseMode = sheet["t_end"], 0
        if setting["method"] == "trapezoidal-index2":
            scheme.generalizedAlpha.useIndex2Constraints = True
            scheme.generalizedAlpha.useNewmark = True
        else:
            scheme.generalizedAlpha.spectralRadius = 0.8
        scheme.newton.useModifiedNewton = True
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = sheet["every"] * (1.0 - 1e-7)
        settings.parallel.numberOfThreads = 1
        kinds = exu.LinearSolverType
        settings.linearSolver.solverType = (
            kinds.EigenSparse if self.coordinates > 100 else kinds.EXUdense
        )
        if sheet.get("data", {}).get("redundant"):
            settings.linearSolver.solverType = kinds.EigenDense
            settings.linearSolver.ignoreSingularJacobian = True
        with Timed() as used:
            self.mbs.SolveDynamic(settings)
        rows = np.asarray(self.mbs.GetSensorStoredData(sensor))[1:]
        if len(rows) != outputs or not np.allclose(rows[:, 0], sheet["times"], atol=1e-6):
            raise RuntimeError(f"{len(rows)} outputs of {outputs}: the solver stopped")
        return rows[:, 1:4].tolist(), used.seconds


def solve(sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """Build and solve."""
    if "beam" in sheet:
        return exudyn_beams.solve(*imported(), sheet, setting)
    return Mechanism(sheet).solve(setting)


if __name__ == "__main__":
    main(solve)
