"""Shell descriptions: expansion, and one message line for each error."""

import hashlib
import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

from plymotion.preprocess import mesh_input
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.common.mesh_files import scripts
from plymotion.solver.inputs.manual import with_keys
from plymotion.solver.inputs.shell import SHAPES
from plymotion.solver.inputs.shell_specification import load_shell

MANUAL = Path(__file__).resolve().parents[2] / "docs" / "shell-description.md"
PLATE = (
    MANUAL.read_text("utf-8").partition("```toml\n")[2].partition("```")[0]
)  # the one of the manual
MSH = """\
$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
5
0 4 "centre"
1 1 "root"
1 2 "tip"
2 3 "plate"
2 5 "rib"
$EndPhysicalNames
"""


@pytest.fixture
def plate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plate.geo").write_text("// no matter what\n")
    (tmp_path / "plate.msh").write_text(MSH)
    (tmp_path / "plate.toml").write_text(PLATE)
    return tmp_path / "plate.toml"


def change(file: Path, old: str, new: str) -> Path:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))
    return file


def with_mesh_file(file: Path) -> Path:
    change(file, '"plate.geo"', '"plate.msh"')
    change(file, "parameters = { n = 16 }", "")
    return change(file, "[regions.plate]", "[regions.all]")


def messages(file: Path) -> list[str]:
    with pytest.raises(InputError) as found:
        load_shell(file)
    lines = str(found.value).splitlines()
    assert all(line.startswith(f"{file}: ") for line in lines)
    return [line.removeprefix(f"{file}: ") for line in lines]


def test_errors_by_the_mesh_where_stresses_matter(plate: Path) -> None:
    text = plate.read_text()
    assert "[frequencies]" in text
    case = next(iter(load_shell(plate)["loads"]))
    added = f'[frequencies]\nprestress = "{case}"'
    for line, expected in (("", True), ("\nerror = false", False)):
        plate.write_text(text.replace("[frequencies]", added + line) + "\n[buckling]\n")
        spec = load_shell(plate)
        assert spec["frequencies"]["error"] is expected
        assert spec["buckling"]["error"] is True
    plate.write_text(text)
    assert "error" not in load_shell(plate)["frequencies"]


def test_angles_are_those_of_a_bound(plate: Path) -> None:
    plate.write_text(f"bound_angles_deg = [0, 90]\n{plate.read_text()}")
    assert load_shell(plate, bound="frequency")["bound_angles_deg"] == [0.0, 90.0]
    assert messages(plate) == ["bound_angles_deg without bound: expected bound, or --bound"]


EXTREME = ["1.7e308", "-1.7e308", "1e200", "-1e31", "1e-320", "1e-308", "nan", "inf", "9" * 400]
NUMBERS = {
    "materials.cfrp.E1": "E1 = {}",
    "materials.cfrp.nu12": "nu12 = {}",
    "materials.cfrp.rho": "rho = {}",
    "laminates.skin.ply_thickness": "ply_thickness = {}",
    "laminates.skin.angles_deg": "angles_deg = [0, {}, -45, 90]",
    "regions.plate.axis": "axis = [1, {}, 0]",
    "loads.bending.tip.force": "force = [0, 0, {}]",
    "loads.weight.all.gravity": "gravity = [0, {}, -9.81]",
    "mesh.parameters": "parameters = {{ n = {} }}",
}


@pytest.mark.parametrize("key", NUMBERS)
@pytest.mark.parametrize("value", EXTREME)
def test_numbers_whose_products_are_no_numbers(plate: Path, key: str, value: str) -> None:
    lines = plate.read_text().splitlines()
    start = NUMBERS[key].split("=")[0]
    (row,) = [i for i, line in enumerate(lines) if line.startswith(start)]
    lines[row] = NUMBERS[key].format(value)
    plate.write_text("\n".join(lines))
    found = messages(plate)
    assert all(line.startswith(key) and len(line) < 300 for line in found)


def test_rounding_near_zero_is_a_number(plate: Path) -> None:
    """As of sines of multiples of pi."""
    change(plate, "axis = [1, 0, 0]", "axis = [1, -1.2246e-16, 1.5e-32]")
    assert load_shell(plate)["regions"]["plate"]["axis"] == [1.0, -1.2246e-16, 1.5e-32]


def test_the_plate_of_the_manual(plate: Path) -> None:
    spec = load_shell(plate)
    assert json.loads(json.dumps(spec)) == spec
    digest = hashlib.sha256(b"// no matter what\n").hexdigest()
    assert spec["mesh"] == {"file": "plate.geo", "sha256": digest, "parameters": {"n": 16}}
    plies = spec["laminates"]["skin"]["plies"]
    assert [ply["angle_deg"] for ply in plies] == [0, 45, -45, 90, 90, -45, 45, 0]
    assert {ply["thickness"] for ply in plies} == {0.125e-3}
    assert spec["laminates"]["skin"]["offset"] == "mid"
    assert spec["laminates"]["skin"]["shear_correction"] == "energy-1d"
    assert spec["regions"] == {
        "plate": {"laminate": "skin", "axis": [1.0, 0.0, 0.0], "flip": False}
    }
    assert spec["elements"] == {
        "plate": "dkmt",
        "membrane": "opt",
        "beta0": 0.5,
        "drilling": "auto",
        "drilling_factor": 1e-2,
        "mass_form": "consistent",
    }
    assert spec["supports"]["root"]["fixed"] == ["ux", "uy", "uz", "rx", "ry", "rz"]
    assert spec["loads"] == {
        "bending": {"tip": {"at": "tip", "force": [0.0, 0.0, 10.0]}},
        "weight": {"all": {"gravity": [0.0, 0.0, -9.81]}},
    }
    assert spec["probes"] == {"tip": {"at": "tip", "what": ["uz", "ry"]}}
    assert spec["frequencies"] == {"count": 4, "free": False}


def test_what_no_region_uses_is_left_out(plate: Path) -> None:
    plate.write_text(
        plate.read_text() + '[materials.steel]\nkind = "isotropic"\nE = 210e9\nnu = 0.3\n'
        'rho = 7850.0\n[laminates.other]\nmaterial = "steel"\nangles_deg = [0]\n'
        "ply_thickness = 1e-3\n"
    )
    spec = load_shell(plate)
    assert set(spec["materials"]) == {"cfrp"}
    assert set(spec["laminates"]) == {"skin"}


def test_one_material_is_a_laminate_of_one_ply(plate: Path) -> None:
    change(plate, 'laminate = "skin"', 'material = "cfrp"\nthickness = 2e-3\noffset = "top"')
    spec = load_shell(plate)
    assert spec["regions"]["plate"]["laminate"] == "plate: cfrp"
    assert spec["laminates"] == {
        "plate: cfrp": {
            "plies": [{"material": "cfrp", "angle_deg": 0.0, "thickness": 2e-3}],
            "offset": "top",
            "shear_correction": "energy-1d",
        }
    }


def test_plies_of_their_own_repeats(plate: Path) -> None:
    change(plate, 'material = "cfrp"\nangles_deg = [0, 45, -45, 90]\nply_thickness = 0.125e-3', "")
    change(
        plate,
        "symmetric = true",
        "repeat = 2\nsymmetric = true\noffset = 1e-3\nshear_correction = [0.8, 0.7]\nplies = [{ "
        'material = "cfrp", angle_deg = 30, thickness = 1e-4, repeat = 2 }, '
        '{ material = "cfrp", thickness = 2e-4 }]',
    )
    skin = load_shell(plate)["laminates"]["skin"]
    half = [30, 30, 0, 30, 30, 0]
    assert [ply["angle_deg"] for ply in skin["plies"]] == [*half, *half[::-1]]
    assert (skin["offset"], skin["shear_correction"]) == (1e-3, [0.8, 0.7])


@pytest.mark.parametrize(
    ("word", "held"), [("symmetry-x", ["ux", "ry", "rz"]), ("symmetry-y", ["uy", "rx", "rz"])]
)
def test_mirrors(plate: Path, word: str, held: list[str]) -> None:
    change(plate, 'fixed = "all"', f'fixed = "{word}"')
    assert load_shell(plate)["supports"]["root"]["fixed"] == held


def test_a_script_is_known_by_all_that_it_reads(plate: Path) -> None:
    change(plate, "plate.geo", "plate.py")
    script = plate.with_name("plate.py")
    script.write_text('grid = run(folder / "grid.py")\n')
    plate.with_name("grid.py").write_text("points = 1\n")
    first = load_shell(plate)["mesh"]["sha256"]
    plate.with_name("grid.py").write_text("points = 2\n")
    assert load_shell(plate)["mesh"]["sha256"] != first


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("format = 1", "format = 2", "format = 2: value should be 1"),
        ('fixed = "all"', 'fixed = ["uxx"]', "supports.root.fixed"),
        ("axis = [1, 0, 0]", "axes = [1, 0, 0]", "regions.plate.axes: unknown key; did you mean"),
        ("axis = [1, 0, 0]", "axis = [0, 0, 0]", "axis = [0, 0, 0]: expected a vector"),
        ("axis = [1, 0, 0]", "", "regions.plate.axis: missing, needed for the direction"),
        ('laminate = "skin"', 'laminate = "skim"', "no such laminate; did you mean 'skin'?"),
        ('laminate = "skin"', 'material = "cfrp"', "expected `thickness` with `material`"),
        (
            'laminate = "skin"',
            'laminate = "skin"\noffset = "top"',
            "expected `offset` with `material` only",
        ),
        ('material = "cfrp"', 'material = "cfpr"', 'laminates.skin = "cfpr": no such material'),
        ("ply_thickness = 0.125e-3", "", "expected `ply_thickness` with the short"),
        ("symmetric = true", 'offset = "botom"', "laminates.skin.offset"),
        ("symmetric = true", 'shear_correction = "5/7"', "laminates.skin.shear_correction"),
        ("force = [0, 0, 10.0]", "", "loads.bending.tip"),
        ("force = [0, 0, 10.0]", "force = [0, 0, 1]\npressure = 1", "found force, pressure"),
        ("[0, 0, -9.81]", '[0, 0, -9.81]\nat = "tip"', "expected no `at` with `gravity`"),
        ('at = "tip"\nwhat', 'at = "tip"\nnear = [0, 0, 0]\nwhat', "either `at` or `near`"),
        ('what = ["uz", "ry"]', 'what = ["uzz"]', "probes.tip.what"),
        ('at = "tip"\nforce', "force", "loads.bending.tip"),
        ("force = [0, 0, 10.0]", "force = [0, 0, 10.0]\nsine = [1, 1, 0]", "expected `sine` with"),
        ("nu12 = 0.42", "nu12 = 4.2", "materials.cfrp.nu12 = 4.2: expected nu12^2 <"),
        ('"plate.geo"', '"plane.geo"', 'mesh.file = "plane.geo": there is no file'),
        ('"plate.geo"', '"plate.inp"', "there is no file"),
        ("count = 4", "count = 0", "frequencies.count = 0"),
    ],
)
def test_messages(plate: Path, old: str, new: str, message: str) -> None:
    assert any(message in line for line in messages(change(plate, old, new)))


def test_nothing_to_compute(plate: Path) -> None:
    text = plate.read_text().partition("[loads.")[0]
    plate.write_text(text)
    assert "no result requested" in messages(plate)[0]


def test_loads_want_supports(plate: Path) -> None:
    change(plate, '[supports.root]\nat = "root"\nfixed = "all"', "")
    assert "loads without supports" in messages(plate)[0]


def test_distributed_loads_on_links(plate: Path) -> None:
    change(plate, "[supports.root]", '[links.hub]\nat = "tip"\nkind = "average"\n[supports.root]')
    change(plate, 'at = "tip"\nforce', 'at = "hub"\nforce')
    assert load_shell(plate)["links"] == {"hub": {"at": "tip", "kind": "average"}}
    change(plate, 'at = "tip"\nkind', 'at = ["tip", "root"]\nkind')
    assert load_shell(plate)["links"]["hub"]["at"] == ["tip", "root"]
    change(plate, "force = [0, 0, 10.0]", "force_per_length = [0, 0, 10.0]")
    assert 'loads.bending.tip.at = "hub": a link takes `force`, `moment` or' in messages(plate)[0]


def test_groups_of_a_mesh_file(plate: Path) -> None:
    spec = load_shell(with_mesh_file(plate))
    assert "parameters" not in spec["mesh"]
    change(plate, 'at = "root"', 'at = "rot"')
    change(plate, "axis = [1, 0, 0]", 'axis_curve = "tips"')
    change(plate, 'at = "tip"\nwhat', 'at = "center"\nwhat')
    found = messages(plate)
    expected = {
        "supports.root.at": "root",
        "probes.tip.at": "centre",
        "regions.all.axis_curve": "tip",
    }
    for key, name in expected.items():
        assert any(f"{key} = " in x and f"did you mean '{name}'?" in x for x in found), key
    assert len(found) == 3


def test_regions_of_a_mesh_file(plate: Path) -> None:
    change(with_mesh_file(plate), "[regions.all]", "[regions.plat]")
    found = messages(plate)
    assert any("regions.plat: plate.msh has no physical surface" in line for line in found)
    for name in ("plate", "rib"):
        assert f"regions.{name}: missing; plate.msh has the physical surfaces plate, rib" in found


def test_parameters_of_a_mesh_file(plate: Path) -> None:
    change(plate, '"plate.geo"', '"plate.msh"')
    assert "mesh.parameters: expected with a script only" in messages(plate)[0]
    change(plate, "parameters = { n = 16 }", "")
    plate.with_name("plate.msh").write_text("solid plate\n")
    assert "not a mesh of gmsh" in messages(plate)[0]


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such shell description"):
        load_shell(tmp_path / "none.toml")


def test_page_is_the_generated_one() -> None:
    """docs/shell-description.md is what `make docs` writes."""
    page = MANUAL.read_text("utf-8")
    assert with_keys(page, "shell") == page


def ready() -> list[Path]:
    return sorted((Path(__file__).resolve().parents[2] / "cases" / "shells").glob("*.toml"))


@pytest.mark.parametrize("file", ready(), ids=lambda file: file.stem)
def test_ready_descriptions(file: Path) -> None:
    spec: dict[str, Any] = load_shell(file)
    assert spec["title"] == tomllib.loads(file.read_text())["title"]


def test_a_shape_of_the_library_is_its_script(plate: Path, repository: Path) -> None:
    """From any folder, with --no-scripts too: the script is none of the user's."""
    assert set(SHAPES) == {f.stem for f in (repository / "meshes/shells").glob("*.py")} - {"grid"}
    change(plate, 'file = "plate.geo"', 'shape = "plate"')
    with scripts(allowed=False):
        mesh = load_shell(plate)["mesh"]
    assert Path(mesh["file"]).resolve() == repository / "meshes/shells/plate.py"
    assert mesh["parameters"] == {"n": 16}
    assert "shape" not in mesh
    change(plate, 'shape = "plate"', 'shape = "plates"')
    assert "did you mean 'plate'?" in messages(plate)[0]
    change(plate, 'shape = "plates"', 'shape = "plate"\nfile = "plate.geo"')
    assert "mesh = {" in messages(plate)[0]
    assert "expected either `file` or `shape`" in messages(plate)[0]


def test_the_preprocessor_refuses_scripts_of_the_user_only(repository: Path) -> None:
    with mesh_input.scripts(refused=True):
        assert mesh_input.is_refused(Path("own/meshes/shells/plate.py"))
        assert not mesh_input.is_refused(repository / "meshes/shells/plate.py")
