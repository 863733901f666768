"""Lay-ups that several tests of laminates share."""

import tomllib
from pathlib import Path
from typing import Any

from plymotion.preprocess.laminate.stiffness import Lamina, Laminate
from plymotion.solver.package.common.materials import Orthotropic, isotropic

FOLDER = Path(__file__).parents[1] / "reference" / "laminates"

CFRP = Orthotropic(135e9, 9.5e9, 9.5e9, 5.0e9, 5.0e9, 3.2e9, 0.31, 0.31, 0.45, 1580.0)
GLASS = Orthotropic(39e9, 8.6e9, 8.6e9, 3.8e9, 3.8e9, 3.0e9, 0.28, 0.28, 0.40, 2100.0)
ALUMINIUM = isotropic(70e9, 0.3, 2700.0)
FOAM = isotropic(70e6, 0.3, 60.0)


def stack(*angles_deg: float, material: Orthotropic = CFRP, ply: float = 0.125e-3) -> Laminate:
    return Laminate(tuple(Lamina(material, angle, ply) for angle in angles_deg))


def hybrid() -> Laminate:
    """Nothing alike: two fibres, a core, an odd angle."""
    return Laminate(
        (
            Lamina(CFRP, 45.0, 0.3e-3),
            Lamina(GLASS, -20.0, 0.2e-3),
            Lamina(FOAM, 0.0, 4.0e-3),
            Lamina(CFRP, 90.0, 0.15e-3),
        )
    )


def reference(name: str) -> dict[str, Any]:
    """A file of tests/reference/laminates."""
    return tomllib.loads((FOLDER / name).read_text(encoding="utf-8"))


def reference_laminates() -> dict[str, Laminate]:
    """The lay-ups of lay-ups.toml, in its units."""
    data = reference("lay-ups.toml")
    found = {}
    for name, table in data["laminates"].items():
        m = data["materials"][table["material"]]
        material = Orthotropic(
            E1=m["E1"],
            E2=m["E2"],
            E3=m["E2"],
            G12=m["G12"],
            G13=m.get("G13", m["G12"]),
            G23=m["G23"],
            nu12=m["nu12"],
            nu13=m["nu12"],
            nu23=0.3,
            rho=1.0,
        )
        angles = table["angles_deg"]
        share = table.get("ply", table.get("total", 0.0) / len(angles))
        thickness = table.get("thickness", [share] * len(angles))
        plies = zip(angles, thickness, strict=True)
        found[name] = Laminate(tuple(Lamina(material, float(a), t) for a, t in plies))
    return found
