"""A shell file in memory, made without FEniCSx: a plate of four triangles under made-up loads."""

import dataclasses
import json
from typing import Any

import numpy as np
from samples.laminate_samples import ALUMINIUM, CFRP

from plymotion.preprocess.laminate.report import report
from plymotion.preprocess.laminate.stiffness import (
    Lamina,
    Laminate,
    laminate_stiffness,
    stress_operators,
)
from plymotion.solver.package.common.materials import Orthotropic
from plymotion.solver.package.common.recovery_schema import ShellPly
from plymotion.solver.package.shell.shell_schema import (
    ShellBuckling,
    ShellCases,
    ShellFile,
    ShellLaminate,
    ShellLinks,
    ShellMeshData,
    ShellModes,
    ShellPlaces,
    ShellProbes,
)

STRENGTH = {"Xt": 1500e6, "Xc": 1200e6, "Yt": 50e6, "Yc": 200e6, "S12": 80e6}


def table_of(material: Orthotropic, strength: dict[str, float] | None = None) -> dict[str, Any]:
    table = {"kind": "orthotropic", **dataclasses.asdict(material)}
    return table | ({"strength": strength} if strength else {})


def laminate_of(name: str, laminate: Laminate, materials: tuple[str, ...]) -> ShellLaminate:
    stiffness, faces = laminate_stiffness(laminate), laminate.faces
    known = json.loads(json.dumps(dataclasses.asdict(report(laminate, name))))
    del known["findings"]
    plies = tuple(
        ShellPly(material, ply.angle_deg, float(bottom), float(top))
        for material, ply, bottom, top in zip(
            materials, laminate.plies, faces[:-1], faces[1:], strict=True
        )
    )
    return ShellLaminate(
        name, plies, stiffness.ABD, stiffness.Ds, stiffness.mass, stress_operators(laminate), known
    )


def plate() -> ShellFile:
    """1 x 0.5 m; the left half is a [0/90]s skin, the right half of aluminium."""
    x, y = np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5])
    nodes = np.column_stack([x.ravel(), y.ravel(), np.zeros(6)])
    cells = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    skin = Laminate(tuple(Lamina(CFRP, angle, 0.25e-3) for angle in (0.0, 90.0, 90.0, 0.0)))
    metal = Laminate((Lamina(ALUMINIUM, 0.0, 2e-3),))
    displacements = np.zeros((2, 6, 6))
    displacements[0, [2, 5], 2] = 0.02, 0.03
    displacements[0, [1, 4], 2] = 0.01
    resultants = np.zeros((2, 4, 8))
    resultants[0, :, 0] = 1e5, 2e5, 3e4, 3e4  # N11
    loads = np.zeros((2, 6))
    loads[0] = [0.0, 0.0, 10.0, 2.5, -10.0, 0.0]  # 10 N at (1, 0.25, 0)
    reactions = np.zeros((2, 1, 6))
    reactions[0, 0] = [0.0, 0.0, -10.0, 0.0, 10.0, 0.0]  # about (0, 0.25, 0)
    shapes = np.zeros((3, 6, 6))
    shapes[1, :, 2] = [0, 1, 2, 0, 1, 2]
    shapes[2, :, 2] = [0, 1, 2, 0, -1, -2]
    return ShellFile(
        name="plate",
        mesh=ShellMeshData(
            nodes_G=nodes,
            node_ids=np.arange(11, 17),
            cells=cells,
            region=np.array([0, 0, 1, 1]),
            regions=("left", "right"),
            laminate=np.array([0, 1]),
            A_GE=np.tile(np.eye(3), (4, 1, 1)),
            area=np.full(4, 0.125),
        ),
        laminates=(
            laminate_of("skin", skin, ("cfrp",) * 4),
            laminate_of("right: aluminium", metal, ("aluminium",)),
        ),
        materials={"cfrp": table_of(CFRP, STRENGTH), "aluminium": table_of(ALUMINIUM)},
        supports=ShellPlaces(("root",), np.array([[0.0, 0.25, 0.0]])),
        links=ShellLinks((), np.zeros((0, 3))),
        cases=ShellCases(
            names=("bending", "nothing"),
            displacements_G=displacements,
            resultants_E=resultants,
            link_motions_G=np.zeros((2, 0, 6)),
            loads_G=loads,
            reactions_G=reactions,
            energy=np.array([0.12, 0.0]),
            residual=np.array([1e-14, 0.0]),
            error=np.array([0.02, 0.0]),
        ),
        probes=ShellProbes(("tip", "tip"), ("uz", "N11"), np.array([[0.025, 3e4], [0.0, 0.0]])),
        modes=ShellModes(
            np.array([0.0, 50.0, 120.0]),
            shapes,
            np.zeros((3, 4, 8)),
            1,
            np.array([0.0, 0.02, 0.04]),
        ),
        buckling=ShellBuckling(
            np.array([0, 0]),
            np.array([2.5, 7.0]),
            shapes[1:],
            np.array([-3.0, 0.0]),
            np.array([0.25, -0.01]),
        ),
        warnings=({"code": "sliver-cells", "message": "two of them"},),
        provenance={"spec": {"title": "Half and half"}, "dofs": 36, "seconds": 0.25},
    )
