"""Meshes from elsewhere run no command: what is in them, beside them, or in the user's folder."""

import os
import random
from pathlib import Path

from harness.hostile_profile import count, tries
from harness.processes import this_python
from samples.case_samples import HEAD, SOLVER

NAMES = ["a.msh", "a.MSH", "a.txt", "a.step", "a.stl", "a.unv", "a.med", "a.msh2", "a", "a.geo.msh"]
HEADS = ["", "", "", " ", "\n", "\ufeff", "// ", "$Comments\n$EndComments\n"]
COMPANIONS = ["{name}.opt", "a.opt", "mesh.msh.opt", ".gmsh-options", ".gmshrc", ".gmsh-session"]
HOME = [".gmshrc", ".gmsh-options", ".gmsh-session", "gmsh.opt"]
MATERIAL = '[materials.m]\nkind = "isotropic"\nE = 7e10\nnu = 0.3\nrho = 2700.0\n'
SECTION = 'format = 1\ntitle = "s"\n[mesh]\nfile = "{name}"\n[regions.skin]\nmaterial = "m"\n'
SHELL = (
    'format = 1\ntitle = "s"\n[mesh]\nfile = "{name}"\n[regions.skin]\nlaminate = "w"\n'
    "axis = [1.0, 0.0, 0.0]\n"
    '[laminates.w]\nmaterial = "m"\nangles_deg = [0]\nply_thickness = 0.001\n'
    "[frequencies]\ncount = 1\n"
)


def _mesh(n: int = 4) -> str:
    """A square of triangles, version 2.2."""
    points = [f"{i + 1} {i % (n + 1) / n} {i // (n + 1) / n} 0" for i in range((n + 1) ** 2)]
    cells = []
    for i in range(n):
        for j in range(n):
            a = i * (n + 1) + j + 1
            for b, c in ((a + 1, a + n + 2), (a + n + 2, a + n + 1)):
                cells.append(f"{len(cells) + 1} 2 2 1 1 {a} {b} {c}")
    return "\n".join(
        [
            *("$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "1", '2 1 "skin"'),
            *("$EndPhysicalNames", "$Nodes", str(len(points)), *points, "$EndNodes"),
            *("$Elements", str(len(cells)), *cells, "$EndElements", ""),
        ]
    )


def _write(folder: Path, name: str, chance: random.Random, strike: str, text: str) -> Path:
    """A description, its mesh with a script somewhere in it or none, and companions."""
    folder.mkdir(parents=True)
    lines = _mesh().splitlines(keepends=True)
    if chance.random() < 0.4:
        lines.insert(chance.choice([0, 3, 7, len(lines)]), strike)
    content = "".join(lines) if chance.random() < 0.9 else strike
    (folder / name).write_text(chance.choice(HEADS) + content, "utf-8")
    for companion in COMPANIONS:
        (folder / companion.format(name=name)).write_text(strike)
    file = folder / f"{folder.name}.toml"
    file.write_text(text.format(name=name) + MATERIAL)
    return file


def _planted(tmp_path: Path, fenicsx: str) -> tuple[str, Path, dict[str, str]]:
    """A script that leaves a file, a current folder and an environment with it at each door."""
    strike = f'SystemCall "touch {tmp_path}/STRUCK";\n'
    home, here = tmp_path / "home", tmp_path / "here"
    for folder, names in ((home, HOME), (here, [*HOME, "mesh.msh.opt"])):
        folder.mkdir()
        for name in names:
            (folder / name).write_text(strike)
    environment = os.environ | {"FENICSX_PYTHON": fenicsx, "HOME": str(home)}
    environment.setdefault("PLYMOTION_CACHE", str(Path.home() / ".cache/plymotion"))
    return strike, here, environment


def test_meshes_and_what_lies_beside_them(tmp_path, fenicsx):
    """With and without --no-scripts; each description is done, or refused by its name."""
    chance = random.Random(4)
    strike, here, environment = _planted(tmp_path, fenicsx)
    ends: set[str] = set()
    for command, text in (("section", SECTION), ("shell", SHELL)):
        # One name that is no mesh's, and `section` stops before it starts the preprocessor.
        for n, names in enumerate((NAMES[:1], NAMES[:1], NAMES)[: tries(1, 3)]):
            more = ["--no-scripts"] if n == 0 else []
            tag = f"{command}{n}"
            files = [
                _write(tmp_path / f"{tag}-{k:02d}", chance.choice(names), chance, strike, text)
                for k in range(tries(6, 25))
            ]
            out = tmp_path / f"out-{tag}"
            words = [command, *map(str, files), "--out", str(out), "--no-figures", "--quiet"]
            done = this_python("-m", "plymotion", *words, *more, env=environment, cwd=here)
            shown = done.stdout + done.stderr
            assert done.returncode in (0, 2), shown
            assert "Traceback" not in shown
            for file in files:
                end = "done" if list(out.rglob(f"{file.stem}.vtkhdf")) else "refused"
                if (tmp_path / "STRUCK").exists():
                    end = "command run"
                count(f"{command}: a mesh with scripts in it and beside it", end)
                ends.add(end)
                assert end == "done" or (end == "refused" and file.stem in shown), (end, shown)
    assert ends == {"done", "refused"}


CASE = (
    HEAD
    + """
[sections.s]
file = "{folder}.toml"
[bodies.arm]
kind = "beam"
length = 9.0
section = "s"
modes = [{{ kind = "bending-xy", count = 1 }}]
interfaces = {{ root = {{ at = "start" }} }}
"""
    + SOLVER.format(t_end=0.02, step=0.01, more="")
)


def test_meshes_of_a_case(tmp_path, fenicsx):
    """The section of a body names one, and the case is run."""
    chance = random.Random(5)
    strike, here, environment = _planted(tmp_path, fenicsx)
    ends: set[str] = set()
    for k in range(tries(3, 24)):
        name = NAMES[0] if k % 3 == 0 else chance.choice(NAMES)
        folder = tmp_path / f"case{k:02d}"
        _write(folder, name, chance, "" if k == 0 else strike, SECTION)
        (folder / "case.toml").write_text(CASE.format(folder=folder.name))
        out = tmp_path / f"out{k:02d}"
        words = [str(folder / "case.toml"), "--out", str(out), "--quiet"]
        done = this_python(
            "-m", "plymotion", *words, *["--no-scripts"] * (k % 2), env=environment, cwd=here
        )
        shown = done.stdout + done.stderr
        end = {0: "done", 2: "refused"}.get(done.returncode, "other")
        end = "traceback" if "Traceback" in shown else end
        end = "command run" if (tmp_path / "STRUCK").exists() else end
        count("run: a mesh with scripts in it and beside it", end)
        ends.add(end)
        assert end == "done" or (end == "refused" and name in shown), (end, shown)
    assert ends <= {"done", "refused"}
    assert "done" in ends
