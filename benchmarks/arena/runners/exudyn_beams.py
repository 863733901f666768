"""Exudyn's geometrically exact beams of two nodes: plane motions, and statics in space."""

from itertools import pairwise
from typing import Any

import numpy as np
from common import Sheet, Timed


def settings(sheet: Sheet) -> list[Sheet]:
    """Elements, and steps with them: both errors are of second order."""
    numbers = (4, 8, 16, 32, 64)
    if sheet["beam"].get("static"):
        return [{"method": "geometrically exact", "elements": n} for n in numbers]
    first = max(len(sheet["times"]), round(100 * sheet["t_end"]))
    return [
        {"method": "geometrically exact", "elements": n, "steps": first * n // 4} for n in numbers
    ]


def plane(exu: Any, items: Any, mbs: Any, sheet: Sheet, n: int) -> int:
    """Nodes, beams, loads and the drive of a plane rod; returns its last node."""
    b = sheet["beam"]
    h, along = b["length"] / n, np.array([np.cos(b["angle"]), np.sin(b["angle"])])
    nodes = [
        mbs.AddNode(
            items.NodeRigidBody2D(
                referenceCoordinates=[*(np.array(b["start"][:2]) + k * h * along), b["angle"]]
            )
        )
        for k in range(n + 1)
    ]
    for pair in pairwise(nodes):
        mbs.AddObject(
            items.ObjectBeamGeometricallyExact2D(
                nodeNumbers=list(pair),
                physicsLength=h,
                physicsMassPerLength=b["mass"],
                physicsCrossSectionInertia=b["rotary"],
                physicsBendingStiffness=b["EI"],
                physicsAxialStiffness=b["EA"],
                physicsShearStiffness=b["GA"],
                includeReferenceRotations=True,
            )
        )
    if "force" in b:
        marker = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0]))
        mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=b["force"]))
        mbs.AddLoad(items.LoadTorqueVector(markerNumber=marker, loadVector=[0, 0, b["moment"]]))
    if "spin_up" in b:
        fixed = mbs.AddNode(items.NodePointGround())
        ground = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=fixed, coordinate=0))
        speed, T = b["spin_up"]["speed"], b["spin_up"]["duration"]

        def angle(mbs: Any, t: float, number: int, offset: float) -> float:
            s = min(t / T, 1.0)
            turn = speed * T * (s * s / 2 + (np.cos(2 * np.pi * s) - 1) / (4 * np.pi**2))
            return float(turn + speed * max(t - T, 0.0))

        for k in range(3):
            root = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=k))
            extra = {"offsetUserFunction": angle} if k == 2 else {}
            mbs.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, root], **extra))
    return int(nodes[-1])


def space(exu: Any, items: Any, mbs: Any, sheet: Sheet, n: int) -> int:
    """A clamped beam in space under a dead force at its end; returns its last node."""
    b = sheet["beam"]
    nodes, turn = [], b["curvature"][2]
    for k in range(n + 1):
        s = b["length"] * k / n
        a = turn * s
        place = [np.sin(a) / turn, (1 - np.cos(a)) / turn, 0.0] if turn else [s, 0.0, 0.0]
        quaternion = [np.cos(a / 2), 0.0, 0.0, np.sin(a / 2)]
        nodes.append(mbs.AddNode(items.NodeRigidBodyEP(referenceCoordinates=[*place, *quaternion])))
    data = exu.BeamSection()
    data.stiffnessMatrix, data.massPerLength, data.inertia = b["K"], 1.0, np.eye(3)
    for pair in pairwise(nodes):
        mbs.AddObject(
            items.ObjectBeamGeometricallyExact(
                nodeNumbers=list(pair), physicsLength=b["length"] / n, sectionData=data
            )
        )
    ground = mbs.AddObject(items.ObjectGround())
    ends = [
        mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground)),
        mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0])),
    ]
    mbs.AddObject(items.ObjectJointGeneric(markerNumbers=ends))
    tip = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[-1]))
    mbs.AddLoad(items.LoadForceVector(markerNumber=tip, loadVector=b["force"]))
    return int(nodes[-1])


def solve(exu: Any, items: Any, sheet: Sheet, setting: Sheet) -> tuple[Any, float]:
    """Build and solve; positions of the end of the rod at the outputs."""
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    static = sheet["beam"].get("static")
    last = (space if static else plane)(exu, items, mbs, sheet, setting["elements"])
    position = exu.OutputVariableType.Position
    sensor = mbs.AddSensor(
        items.SensorNode(nodeNumber=last, outputVariableType=position, storeInternal=True)
    )
    mbs.Assemble()
    options = exu.SimulationSettings()
    options.solution.file.write = False
    options.parallel.numberOfThreads = 1
    options.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    if static:
        options.staticSolver.numberOfLoadSteps = 8
        options.staticSolver.newton.relativeTolerance = 1e-10
        with Timed() as used:
            mbs.SolveStatic(options)
        return [mbs.GetNodeOutput(last, position).tolist()], used.seconds
    scheme, outputs = options.timeIntegration, len(sheet["times"])
    scheme.numberOfSteps = outputs * max(1, round(setting["steps"] / outputs))
    scheme.endTime, scheme.verboseMode = sheet["t_end"], 0
    scheme.generalizedAlpha.spectralRadius = 0.8
    # full Newton; at 1e-8 and 1e-10 the stiff stretch of a beam at rest keeps it from converging
    scheme.newton.relativeTolerance, scheme.newton.absoluteTolerance = 1e-6, 1e-4
    options.solution.sensors.writePeriod = sheet["every"] * (1.0 - 1e-7)
    with Timed() as used:
        mbs.SolveDynamic(options)
    rows = np.asarray(mbs.GetSensorStoredData(sensor))[1:]
    if len(rows) != outputs:
        raise RuntimeError(f"{len(rows)} outputs of {outputs}: the solver stopped")
    return rows[:, 1:4].tolist(), used.seconds
