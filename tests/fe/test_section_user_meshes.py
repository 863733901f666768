"""Meshes of sections from the user's scripts and files."""

from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.section_mesh_samples import moments, nodes_of

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx import gmsh
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.section_specification import SectionError
from plymotion.preprocess.section.space.section_mesh import section_mesh

# A quarter of a ring, inner radius 1, outer 2: two regions, the outer arc named.
RING = """
DefineConstant[ n = {4, Name "Parameters/n"} ];
Mesh.ElementOrder = ORDER;
Mesh.SecondOrderIncomplete = INCOMPLETE;
Point(1) = {0, 0, 0};
For k In {0:2}
  Point(10 + k) = {Cos(k * Pi / 4), Sin(k * Pi / 4), 0};
  Point(20 + k) = {2 * Cos(k * Pi / 4), 2 * Sin(k * Pi / 4), 0};
  Line(30 + k) = {10 + k, 20 + k};
EndFor
For k In {0:1}
  Circle(10 + k) = {10 + k, 1, 11 + k};
  Circle(20 + k) = {20 + k, 1, 21 + k};
  Curve Loop(k + 1) = {30 + k, 20 + k, -(31 + k), -(10 + k)};
  Plane Surface(k + 1) = {k + 1};
  Transfinite Surface {k + 1};
  RECOMBINE
EndFor
Transfinite Curve {10, 11, 20, 21, 30, 31, 32} = n + 1;
Physical Surface("low") = {1};
Physical Surface("high") = {2};
Physical Curve("outer") = {20, 21};
"""


KINDS: dict[str, dict[str, Any]] = {
    "triangle": {"ORDER": 1, "INCOMPLETE": 0, "RECOMBINE": ""},
    "triangle6": {"ORDER": 2, "INCOMPLETE": 0, "RECOMBINE": ""},
    "quad": {"ORDER": 1, "INCOMPLETE": 0, "RECOMBINE": "Recombine Surface {k + 1};"},
    "quad8": {"ORDER": 2, "INCOMPLETE": 1, "RECOMBINE": "Recombine Surface {k + 1};"},
    "quad9": {"ORDER": 2, "INCOMPLETE": 0, "RECOMBINE": "Recombine Surface {k + 1};"},
}


def ring_text(kind: str) -> str:
    text = RING
    for word, value in KINDS[kind].items():
        text = text.replace(word, str(value))
    return text


def ring(folder: Path, kind: str) -> Path:
    path = folder / f"{kind}.geo"
    path.write_text(ring_text(kind))
    return path


def saved(script: Path, target: Path, **options: float) -> Path:
    """Mesh a script with gmsh and save it, as a user would."""
    with fenicsx.gmsh_session():
        gmsh.clear()
        gmsh.merge(str(script))
        gmsh.model.mesh.generate(2)
        for name, value in options.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
        gmsh.write(str(target))
        gmsh.clear()
    return target


@pytest.mark.one_end
@pytest.mark.parametrize("kind", KINDS)
def test_user_script_and_saved_mesh_agree(kind: str, tmp_path: Path) -> None:
    script = ring(tmp_path, kind)
    by_script = section_mesh({"file": str(script)}, "ring")
    degree = 2 if kind[-1].isdigit() else 1
    assert by_script.cells.degree == degree
    assert set(by_script.cells.regions) == {"low", "high"}
    segments = by_script.curves["outer"]
    assert segments.shape == (8, degree + 1, 2)
    assert np.hypot(*segments.reshape(-1, 2).T) == pytest.approx(2.0)
    for version, binary in ((2.2, 0), (4.1, 0), (4.1, 1)):
        path = saved(script, tmp_path / f"{kind}.msh", MshFileVersion=version, Binary=binary)
        by_file = section_mesh({"file": str(path)}, "ring")
        assert by_file.cells.n_cell == by_script.cells.n_cell
        assert moments(by_file) == pytest.approx(moments(by_script), rel=1e-12)
        assert by_file.curves.keys() == {"outer"}
        for region in ("low", "high"):
            centre = [nodes_of(m, region).mean(axis=(0, 1)) for m in (by_file, by_script)]
            assert centre[0] == pytest.approx(centre[1])


@pytest.mark.one_end
@pytest.mark.parametrize("kind", KINDS)
def test_refined_script_follows_its_geometry(kind: str, tmp_path: Path) -> None:
    script = ring(tmp_path, kind)
    exact = pi * (4 - 1) / 4
    areas = [
        moments(section_mesh({"file": str(script), "parameters": {"n": n}}, "x"))[0]
        for n in (4, 8, 16)
    ]
    errors = np.abs(np.array(areas) / exact - 1.0)
    order = 2 if KINDS[kind]["ORDER"] == 1 else 4
    assert np.all(np.log2(errors[:-1] / errors[1:]) > order - 0.3)


def test_eight_and_nine_nodes_make_the_same_section(tmp_path: Path) -> None:
    eight, nine = (section_mesh({"file": str(ring(tmp_path, k))}, "x") for k in ("quad8", "quad9"))
    assert moments(eight) == pytest.approx(moments(nine), rel=1e-4)


@pytest.mark.one_end
def test_parameters_lists_and_scale(tmp_path: Path) -> None:
    script = ring(tmp_path, "quad9")
    fine = section_mesh({"file": str(script), "parameters": {"n": 8}}, "x")
    assert fine.cells.n_cell == 2 * 8 * 8
    small = section_mesh({"file": str(script), "scale": 1e-3}, "x")
    plain = section_mesh({"file": str(script)}, "x")
    scales = np.array([2, 3, 3, 4, 4, 4])
    assert moments(small) == pytest.approx(moments(plain) * 1e-3**scales, rel=1e-12)
    assert small.curves["outer"] == pytest.approx(1e-3 * plain.curves["outer"])
    with pytest.raises(SectionError, match="no parameter m"):
        section_mesh({"file": str(script), "parameters": {"m": 8}}, "x")


def test_script_with_a_macro_is_read_again_and_again(tmp_path: Path) -> None:
    """gmsh reads a Macro once in a process."""
    path = tmp_path / "macro.geo"
    path.write_text(
        'DefineConstant[ a = {1, Name "Parameters/a"} ];\nMacro Side\n'
        "  l[] = Extrude {a, 0, 0} { Point{1}; Layers{2}; };\nReturn\n"
        "Point(1) = {0, 0, 0};\nCall Side;\n"
        "s[] = Extrude {0, 1, 0} { Line{l[1]}; Layers{2}; Recombine; };\n"
        'Physical Surface("body") = {s[1]};\nPhysical Curve("foot") = {l[1]};\n'
    )
    for a in (1.0, 2.0, 3.0):
        mesh = section_mesh({"file": str(path), "parameters": {"a": a}}, "x")
        assert moments(mesh)[0] == pytest.approx(a)
        assert np.ptp(mesh.curves["foot"][..., 0]) == pytest.approx(a)


@pytest.mark.one_end
def test_one_table_for_all_regions_of_a_script(tmp_path: Path) -> None:
    path = tmp_path / "two.geo"
    path.write_text(
        "Point(1) = {0, 0, 0};\nl[] = Extrude {1, 0, 0} { Point{1}; Layers{2}; };\n"
        "a[] = Extrude {0, 1, 0} { Line{l[1]}; Layers{2}; Recombine; };\n"
        "b[] = Extrude {0, 1, 0} { Line{a[0]}; Layers{2}; Recombine; };\n"
        'Physical Surface("lower") = {a[1]};\nPhysical Surface("upper") = {b[1]};\n'
    )
    materials = {
        name: {"kind": "isotropic", "E": E, "nu": 0.3, "rho": 1.0}
        for name, E in (("soft", 1.0), ("stiff", 3.0))
    }

    def table(material: str) -> dict[str, Any]:
        return {"plies": [{"material": material}], "direction": {"vector": [1.0, 0.0]}}

    for regions, EA in (
        ({"all": table("soft")}, 2.0),
        ({"all": table("soft"), "upper": table("stiff")}, 4.0),
    ):
        spec = {"mesh": {"file": str(path)}, "materials": materials, "regions": regions}
        assert analyse(spec, estimate=False).K[0, 0] == pytest.approx(EA)
    with pytest.raises(SectionError, match=r"regions\.uper: the mesh has no such region.*upper"):
        analyse({**spec, "regions": {"all": table("soft"), "uper": table("stiff")}})


def test_arrays(tmp_path: Path) -> None:
    """Arrays in the form that the solver writes for meshes of other programs."""
    path = tmp_path / "part.npz"
    np.savez(
        path,
        points=[[0.0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1], [5, 5]],
        cells=[[0, 1, 2, 3], [1, 4, 5, 2]],
        cell_type="quad",
        region=[1, 0],
        region_names=["right", "left"],
        lines=[[0, 1], [1, 4]],
        curve=[0, 0],
        curve_names=["foot"],
    )
    mesh = section_mesh({"arrays": str(path), "scale": 2.0}, "part")
    assert nodes_of(mesh, "left")[..., 0].max() == 2.0
    assert mesh.curves["foot"].shape == (2, 2, 2)
    assert moments(mesh)[0] == pytest.approx(8.0)


@pytest.mark.one_end
def test_equal_requests_share_a_mesh_until_the_file_changes(tmp_path: Path) -> None:
    script = ring(tmp_path, "quad")
    first = section_mesh({"file": str(script)}, "x")
    assert section_mesh({"file": str(script)}, "another section") is first
    script.write_text(ring_text("quad9"))
    assert section_mesh({"file": str(script)}, "x").cells.degree == 2
