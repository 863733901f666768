"""Sections, shells and solids whose materials or sizes cannot be in SI units."""

from pathlib import Path
from typing import Any

import pytest

from plymotion.preprocess.body import build_body
from plymotion.preprocess.section.section_analysis import analyse as section
from plymotion.preprocess.shell.analyses.shell_analysis import analyse as shell
from plymotion.solver.inputs.section.shapes.library import expand

pytestmark = pytest.mark.one_end

METAL = {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}
CARBON = {
    **{"kind": "orthotropic", "E1": 140e9, "E2": 9e9, "E3": 9e9, "rho": 1600.0},
    **{"G12": 5e9, "G13": 5e9, "G23": 3.5e9, "nu12": 0.3, "nu13": 0.3, "nu23": 0.4},
}


def of_section(scale: float = 1.0, material: Any = METAL, **more: Any) -> list[str]:
    """Codes of a bar of 50 by 2 mm."""
    found = section(
        {
            "mesh": expand("rectangle", {"width": 0.05 * scale, "height": 0.002 * scale}),
            "materials": {"m": material},
            "regions": {
                "section": {"plies": [{"material": "m"}], "direction": {"vector": [1.0, 0.0]}}
            },
            **more,
        },
        estimate=False,
    )
    return [warning["code"] for warning in found.warnings]


def test_sections() -> None:
    assert of_section() == of_section(material=CARBON) == []
    for change in ({"E": 70.0}, {"E": 70e3}, {"rho": 2.7}, {"E": 70.0, "rho": 2.7}):
        assert of_section(material=METAL | change) == ["material-units"], change
    assert of_section(material=CARBON | {"E2": 9.0, "E3": 9.0}) == ["material-units"]
    assert of_section(1e3) == of_section(0.6e3) == ["size-units"]  # by its size; by its mass
    assert of_section(1e3, allow=["size-units"]) == []
    assert of_section(material=METAL | {"E": 70.0}, allow=["material-units"]) == []


GEO = """SetFactory("OpenCASCADE");
Rectangle(1) = {{0, 0, 0, {0}, {1}}};
Mesh.MeshSizeMin = {0} / 3;
Mesh.MeshSizeMax = {0} / 3;
Physical Surface("all") = {{1}};
"""


def of_shell(
    folder: Path, scale: float, thickness: float, material: Any = METAL, plies: int = 1, **more: Any
) -> list[str]:
    """Codes of a plate of 0.3 by 0.2 m, times a scale."""
    (folder / "plate.geo").write_text(GEO.format(0.3 * scale, 0.2 * scale))
    ply = {"material": "m", "angle_deg": 0.0, "thickness": thickness / plies}
    found = shell(
        {
            "mesh": {"file": str(folder / "plate.geo")},
            "materials": {"m": material},
            "laminates": {"a": {"plies": [ply] * plies}},
            "regions": {"all": {"laminate": "a", "axis": [1.0, 0.0, 0.0]}},
            "frequencies": {"count": 1},
            **more,
        }
    )
    return [warning["code"] for warning in found.warnings if warning["code"].endswith("units")]


def test_shells(tmp_path: Path) -> None:
    assert of_shell(tmp_path, 1.0, 2e-3) == of_shell(tmp_path, 1.0, 1e-3, CARBON, 8) == []
    assert of_shell(tmp_path, 1.0, 0.4) == ["size-units"]  # thicker than long
    assert of_shell(tmp_path, 2e3, 0.4) == ["size-units"]  # by its mass
    assert of_shell(tmp_path, 100.0, 2.0) == ["size-units"]  # a small sheet, by its thickness
    assert of_shell(tmp_path, 100.0, 2.0, METAL | {"E": 30e9}) == []  # a dam of concrete
    assert of_shell(tmp_path, 1e3, 1.0, CARBON, 8) == ["size-units"]  # by its plies
    assert of_shell(tmp_path, 1.0, 2.0, allow=["size-units"]) == []
    assert of_shell(tmp_path, 1.0, 2e-3, METAL | {"E": 70.0, "rho": 2.7}) == ["material-units"]


BOX = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 2, 1, 1};
Mesh.MeshSizeMin = 1;
"""


def of_solid(folder: Path, unit: float = 0.1, material: Any = METAL, **more: Any) -> list[str]:
    """Codes of `plymotion solid` for a block of two by one by one units of length [m]."""
    (folder / "block.geo").write_text(BOX)
    spec = {
        "body": "block",
        "kind": "solid",
        "solid": {
            "mesh": {"file": str(folder / "block.geo"), "unit": unit},
            "materials": {"m": material},
            "regions": {"all": {"material": "m"}},
            **more,
        },
        "reference": {"kind": "mean-axis"},
        "modes": [{"kind": "lowest", "count": 1}],
        "damping_ratio": 0.0,
        "interfaces": {},
        "analysis": {"supports": [], "loads": {}, "error": False},
    }
    return [warning["code"] for warning in build_body(spec).provenance["warnings"]]


def test_solids(tmp_path: Path) -> None:
    assert of_solid(tmp_path) == []
    assert of_solid(tmp_path, material=METAL | {"E": 70.0}) == ["material-units"]
    assert of_solid(tmp_path, unit=100.0) == ["size-units"]  # by its mass
    assert of_solid(tmp_path, unit=100.0, allow=["size-units"]) == []


@pytest.mark.parametrize("density", [1.0, 0.5])
def test_examples_without_units_are_no_mistakes(density: float) -> None:
    """BECAS, ANBA4: E = 100, rho = 1; a density of 0.5 is no such example."""
    found = of_section(material=METAL | {"E": 100.0, "rho": density})
    assert found == ([] if density == 1.0 else ["material-units"])
