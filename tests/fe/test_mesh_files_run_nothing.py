"""Meshes that gmsh reads run no command: in them, beside them or in the current folder."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from plymotion.preprocess import fenicsx
from plymotion.preprocess.__main__ import main
from plymotion.preprocess.fenicsx import MeshError, gmsh, open_mesh
from plymotion.preprocess.section.section_specification import SectionError
from plymotion.preprocess.section.space.section_mesh import section_mesh
from plymotion.preprocess.shell.shell_mesh import ShellError, shell_mesh

pytestmark = pytest.mark.one_end
SQUARE = """\
Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {1, 1, 0}; Point(4) = {0, 1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Physical Surface("skin") = {1};
"""
NAMES = ("a.msh", "a.MSH", "a.txt", "a.step", "a.stl", "a.unv", "a.med", "a")
COMPANIONS = ("square.msh.opt", "square.opt", ".gmsh-options", ".gmshrc", ".gmsh-session")


@pytest.fixture
def square(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A mesh in the current folder."""
    monkeypatch.chdir(tmp_path)
    script = tmp_path / "square.geo"
    script.write_text(SQUARE)
    with fenicsx.gmsh_session():
        gmsh.clear()
        gmsh.open(str(script))
        gmsh.model.mesh.generate(2)
        gmsh.write(str(tmp_path / "square.msh"))
        gmsh.clear()
    script.unlink()
    return tmp_path / "square.msh"


def strike(folder: Path) -> str:
    """A script that leaves a file."""
    return f'SystemCall "touch {folder}/STRUCK";\n'


@pytest.mark.parametrize("companion", COMPANIONS)
def test_companions_of_a_mesh_are_not_read(square: Path, companion: str) -> None:
    (square.parent / companion).write_text(strike(square.parent))
    assert section_mesh({"file": str(square)}, "mesh").cells.regions == ("skin",)
    assert shell_mesh({"file": "square.msh"}, "mesh").regions == ("skin",)
    assert not (square.parent / "STRUCK").exists()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("head", ["", " ", "\n", "\ufeff", "// "])
def test_a_script_under_another_name_is_no_mesh(square: Path, name: str, head: str) -> None:
    file = square.parent / name
    file.write_text(head + square.read_text() + strike(square.parent))
    if head:  # gmsh takes it for a script
        with pytest.raises(MeshError, match=r"not a mesh of gmsh, expected \$MeshFormat"):
            open_mesh(file)
    else:
        open_mesh(file)
    file.write_text(head + strike(square.parent))
    with pytest.raises(MeshError, match="not a mesh of gmsh"):
        open_mesh(file)
    assert not (square.parent / "STRUCK").exists()


@pytest.mark.parametrize("name", ["own.geo", 'o"wn.geo', "o'wn.geo"])
def test_the_companion_of_an_allowed_script_is_not_read(square: Path, name: str) -> None:
    """The script itself runs: it includes and names other files of its folder as before."""
    folder = square.parent
    (folder / name).write_text(f'SystemCall "touch {folder}/RAN";\nInclude "more/part.geo";\n')
    (folder / "more").mkdir()
    (folder / "more/part.geo").write_text(SQUARE)
    for companion in (f"{name}.opt", "more/part.geo.opt"):
        (folder / companion).write_text(strike(folder))
    fenicsx.check_count(folder / name, {})
    assert fenicsx.run_script(folder / name, {}).cells.size
    assert (folder / "RAN").exists()
    assert not (folder / "STRUCK").exists()


def test_an_error_names_the_file_of_the_user(square: Path) -> None:
    square.write_text("$MeshFormat\n" + strike(square.parent))
    with pytest.raises(MeshError, match=r"square\.msh") as caught:
        open_mesh(square)
    assert "plymotion-" not in str(caught.value)
    assert not (square.parent / "STRUCK").exists()


@pytest.mark.parametrize("suffix", [".geo", ".py"])
def test_specifications_with_scripts_are_refused(
    square: Path, suffix: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A specification of a body from elsewhere may name one; check has not seen it."""
    folder = square.parent
    script = folder / f"own{suffix}"
    python = f"open({str(folder / 'STRUCK')!r}, 'w')\ndef build(gmsh, parameters): pass\n"
    script.write_text(python if suffix == ".py" else strike(folder) + SQUARE)
    shell = {"mesh": {"file": str(script)}, "materials": {}, "laminates": {}, "regions": {}}
    spec = folder / "arm.json"
    spec.write_text(json.dumps({"name": "arm", "title": "arm", **shell}))
    assert main(["shell", str(spec), "--no-scripts"]) == 2
    capsys.readouterr()
    from plymotion.preprocess.mesh_input import scripts

    with scripts(refused=True):
        with pytest.raises(ShellError, match="expected no script with --no-scripts"):
            shell_mesh({"file": str(script)}, "mesh")
        with pytest.raises((SectionError, MeshError), match="expected no script"):
            section_mesh({"file": str(script)}, "mesh")
        for name in ("../own", "/own", "box/../own"):
            with pytest.raises(SectionError, match="name of a script of the library"):
                section_mesh({"script": name}, "mesh")
    assert not (folder / "STRUCK").exists()


@pytest.mark.parametrize("guarded", [True, False])
def test_petsc_does_not_read_the_current_folder(tmp_path: Path, guarded: bool) -> None:
    """Its .petscrc can name a library to load; petsc4py alone reads it."""
    (tmp_path / ".petscrc").write_text("-planted_by_others 1\n")
    code = "from plymotion.preprocess.fenicsx.libraries import PETSc\n"
    if not guarded:
        code = "from mpi4py import MPI\nfrom plymotion.preprocess.fenicsx import libraries\n"
        code += "libraries._part('MPI')\nimport petsc4py\npetsc4py.init([''])\n"
        code += "from petsc4py import PETSc\n"
    code += "print(PETSc.Options().hasName('planted_by_others'))"
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout == f"{not guarded}\n", done.stderr


def test_a_script_does_not_merge_a_file_with_a_companion(square: Path) -> None:
    """gmsh would run it; without the companion the same script merges the mesh."""
    folder = square.parent
    script = folder / "own.geo"
    script.write_text('Include "part.geo";\n')
    (folder / "part.geo").write_text(f'Merge "{square.name}";\n')
    companion = folder / f"{square.name}.opt"
    companion.write_text(strike(folder))
    fenicsx.check_count(script, {})
    with pytest.raises(MeshError, match=r"Merge \"square.msh\" would run .*square.msh.opt"):
        fenicsx.run_script(script, {})
    assert not (folder / "STRUCK").exists()
    companion.unlink()
    assert fenicsx.run_script(script, {}).cells.size


@pytest.mark.parametrize(
    "words",
    [
        'Merge StrCat("{}", ".msh");',
        'name = "{}.msh"; Merge Str(name);',
        'Merge /* a comment */ "{}.msh";',
    ],
    ids=["StrCat", "variable", "comment"],
)
def test_a_script_that_computes_a_name_does_not_merge_a_file_with_a_companion(
    square: Path, words: str
) -> None:
    folder = square.parent
    script = folder / "own.geo"
    script.write_text(words.format(square.stem) + "\n")
    companion = folder / f"{square.name}.opt"
    companion.write_text(strike(folder))
    with pytest.raises(MeshError, match=r"computes the name .*square.msh.opt as a script"):
        fenicsx.run_script(script, {})
    assert not (folder / "STRUCK").exists()
    companion.unlink()
    assert fenicsx.run_script(script, {}).cells.size
