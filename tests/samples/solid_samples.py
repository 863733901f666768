"""Parts as CAD files, made by gmsh's OpenCASCADE in millimetres, and decks of CalculiX."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from plymotion.preprocess import fenicsx
from plymotion.preprocess.solid.model import SolidModel
from plymotion.solver.math.arrays import IntArray

ALUMINIUM = {"kind": "isotropic", "E": 70e9, "nu": 0.33, "rho": 2700.0}
STEEL = {"kind": "isotropic", "E": 210e9, "nu": 0.3, "rho": 7850.0}
WOUND = {
    **{"kind": "orthotropic", "E1": 120e9, "E2": 9e9, "E3": 9e9, "G12": 5e9, "G13": 5e9},
    **{"G23": 3e9, "nu12": 0.3, "nu13": 0.3, "nu23": 0.4, "rho": 1600.0},
}
INCH = (
    "( CONVERSION_BASED_UNIT('INCH',#9001) LENGTH_UNIT() NAMED_UNIT(#9002) );\n"
    "#9001 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#9003);\n"
    "#9002 = DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);\n"
    "#9003 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"
)
MILLIMETRE = "( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );"


class Rigid(NamedTuple):
    """Inertia of a part of density 1, in its drawing's unit."""

    volume: float
    centre: np.ndarray
    inertia: np.ndarray  # about the centre


def bar(occ: Any) -> None:
    """Draw a bar of 200 x 12 x 8 along x."""
    occ.addBox(0, -6, -4, 200, 12, 8)


def bracket(occ: Any) -> None:
    """Draw a plate with two bores and a rib."""
    plate, rib = occ.addBox(0, 0, 0, 100, 40, 10), occ.addBox(30, 15, 10, 40, 10, 25)
    bores = [(3, occ.addCylinder(x, 20, -1, 0, 0, 12, r)) for x, r in ((15, 8), (85, 6))]
    whole, _ = occ.fuse([(3, plate)], [(3, rib)])
    occ.cut(whole, bores)


def thin_rib(occ: Any) -> None:
    """Draw a plate with a rib of a fiftieth of its length."""
    plate, rib = occ.addBox(0, 0, 0, 100, 40, 8), occ.addBox(5, 19, 8, 90, 2, 30)
    occ.fuse([(3, plate)], [(3, rib)])


def two_solids(occ: Any) -> None:
    """Draw a bush in a block: two solids that touch."""
    block = occ.addBox(-20, -20, 0, 40, 40, 25)
    block = occ.cut([(3, block)], [(3, occ.addCylinder(0, 0, -1, 0, 0, 27, 12))])[0][0][1]
    bush = occ.addCylinder(0, 0, 0, 0, 0, 25, 12)
    occ.cut([(3, bush)], [(3, occ.addCylinder(0, 0, -1, 0, 0, 27, 8))])


def filleted(occ: Any) -> None:
    """Draw a bar with small fillets along its edges."""
    box = occ.addBox(0, 0, 0, 80, 30, 20)
    occ.synchronize()
    edges = [tag for _, tag in fenicsx.gmsh.model.getEntities(1)]
    occ.fillet([box], edges, [2.0])


def tube(occ: Any) -> None:
    """Draw a tube along z."""
    outer = occ.addCylinder(0, 0, 0, 0, 0, 120, 25)
    occ.cut([(3, outer)], [(3, occ.addCylinder(0, 0, -1, 0, 0, 122, 20))])


def cad_file(path: Path, draw: Callable[[Any], None]) -> list[Rigid]:
    """Write a drawing in mm; returns the inertia of its solids before they were written."""
    with fenicsx.gmsh_session() as gmsh:
        gmsh.clear()
        occ = gmsh.model.occ
        draw(occ)
        occ.synchronize()
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        found = [
            Rigid(
                occ.getMass(*tag),
                np.array(occ.getCenterOfMass(*tag)),
                np.reshape(occ.getMatrixOfInertia(*tag), (3, 3)),
            )
            for tag in gmsh.model.getEntities(3)
        ]
        gmsh.write(str(path))
        gmsh.clear()
    return found


def step_file(path: Path, draw: Callable[[Any], None], unit: str = MILLIMETRE) -> list[Rigid]:
    """Write a drawing as STEP with its unit of length."""
    found = cad_file(path, draw)
    text = path.read_text()
    assert MILLIMETRE in text
    path.write_text(text.replace(MILLIMETRE, unit))
    return found


def one_body(parts: list[Rigid], density: list[float], length: float) -> tuple[float, Any, Any]:
    """Mass, centre and inertia about the centre of rigidly joined parts, in SI."""
    mass = np.array([d * length**3 * p.volume for d, p in zip(density, parts, strict=True)])
    x = np.array([length * p.centre for p in parts])
    centre = mass @ x / mass.sum()
    J = sum(d * length**5 * p.inertia for d, p in zip(density, parts, strict=True))
    for m, arm in zip(mass, x - centre, strict=True):
        J = J + m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return float(mass.sum()), centre, J


def model_of(file: Path, size: float | None, material: Any = ALUMINIUM, **more: Any) -> SolidModel:
    """One material everywhere; `more`: interfaces, region, unit."""
    mesh = {"file": str(file), "size": size}
    if "unit" in more:
        mesh["unit"] = more["unit"]
    return SolidModel(
        {
            "mesh": mesh,
            "materials": {"stuff": material},
            "regions": {"all": {"material": "stuff", **more.get("region", {})}},
        },
        more.get("interfaces", {}),
    )


def elastic(m: dict[str, Any]) -> list[str]:
    """Lines of the constants; 1, 2, 3 of an orthotropic material are around, along z, outwards.

    CalculiX's cylindrical axes are outwards, around, along z.
    """
    if m["kind"] == "isotropic":
        return ["*ELASTIC", f"{m['E']!r},{m['nu']!r}"]
    nu31, nu32 = m["nu13"] * m["E3"] / m["E1"], m["nu23"] * m["E3"] / m["E2"]
    numbers = [m["E3"], m["E1"], m["E2"], nu31, nu32, m["nu12"], m["G13"], m["G23"], m["G12"], 293]
    first, rest = (",".join(f"{x:.10e}" for x in part) for part in (numbers[:8], numbers[8:]))
    return ["*ELASTIC, TYPE=ENGINEERING CONSTANTS", first, rest]


def calculix_deck(
    path: Path, model: SolidModel, material: dict[str, Any], count: int, held: IntArray
) -> None:
    """Write the same nodes and cells as C3D10, and a frequency step with rows of nodes held."""
    body = model.body
    lines = ["*NODE, NSET=NALL"]
    lines += [f"{i},{x:.12e},{y:.12e},{z:.12e}" for i, (x, y, z) in enumerate(body.nodes, 1)]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=EALL")
    # nodes of C3D10: edges 12, 23, 13, 14, 24, 34, as VTK's quadratic tetrahedron
    cells = body.cells.connectivity.reshape(-1, 10) + 1
    lines += [f"{i}," + ",".join(map(str, row)) for i, row in enumerate(cells.tolist(), 1)]
    section = "*SOLID SECTION, ELSET=EALL, MATERIAL=M"
    lines += ["*MATERIAL, NAME=M", *elastic(material), "*DENSITY", f"{material['rho']!r}"]
    if material["kind"] == "orthotropic":  # its axes turn about z
        lines += ["*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL", "0,0,0,0,0,1"]
        section += ", ORIENTATION=O"
    lines.append(section)
    lines += ["*BOUNDARY", *(f"{i + 1},1,3" for i in held.tolist())]
    lines += ["*STEP", "*FREQUENCY", f"{count}", "*END STEP"]
    path.write_text("\n".join(lines) + "\n")
