"""DOLFINx compiles into our own folder, and goes on after a process that was killed there."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from harness.processes import this_python
from samples.section_cases import section
from samples.section_specs import rectangle_spec
from samples.shell_specs import METAL

FORM = """
from plymotion.preprocess.fenicsx import libraries
import ufl
from mpi4py import MPI
mesh = libraries.dolfinx.mesh.create_unit_interval(MPI.COMM_SELF, 2)
make = getattr(libraries.dolfinx.fem, "functionspace", None) or libraries.dolfinx.fem.FunctionSpace
space = make(mesh, ("Lagrange", 1))
v = ufl.TestFunction(space)
print(type(libraries.dolfinx.fem.form(v * ufl.dx)).__name__)
"""


def _compiled(cache: Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-c", FORM],
        env={**os.environ, "PLYMOTION_CACHE": str(cache)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=120,
    )


def test_a_killed_compilation_is_done_again(tmp_path: Path) -> None:
    first = _compiled(tmp_path)
    assert first.returncode == 0, first.stdout
    folder = tmp_path / "forms/fenics"
    marks = list(folder.glob("*.c.cached"))
    assert marks
    for mark in marks:  # as after a kill in the middle
        mark.unlink()
    again = _compiled(tmp_path)
    assert again.returncode == 0, again.stdout
    assert sorted(folder.glob("*.c.cached")) == sorted(marks)


@pytest.mark.one_end
def test_sections_of_the_library_find_what_make_compiled(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    cache.mkdir()
    environment = {**os.environ, "PLYMOTION_CACHE": str(cache)}
    words = "from plymotion.preprocess.precompile import section; section('quadrilateral')"
    subprocess.run([sys.executable, "-c", words], env=environment, check=True, timeout=120)
    compiled = sorted(cache.rglob("*.so"))
    assert compiled
    specs = [tmp_path / f"{name}.json" for name in ("box", "tube")]
    for path, number in zip(specs, ("21", "06"), strict=True):
        path.write_text(json.dumps(section(number)))
    command = [sys.executable, "-m", "plymotion.preprocess", "section", *map(str, specs)]
    subprocess.run(command, env=environment, check=True, timeout=120)
    assert sorted(cache.rglob("*.so")) == compiled


def test_a_compiler_that_fails_is_told(tmp_path: Path) -> None:
    spec = tmp_path / "bar.json"
    spec.write_text(json.dumps(rectangle_spec(2.0, 1.0, METAL)))
    cache = tmp_path / "cache"
    cache.mkdir()
    done = this_python(
        "-m",
        "plymotion.preprocess",
        "section",
        spec,
        more={"PLYMOTION_CACHE": str(cache), "CC": str(tmp_path / "no-cc")},
        timeout=120,
    )
    assert done.returncode == 2
    assert "DOLFINx needs a C compiler and Python's headers" in done.stderr
    assert "no-cc" in done.stderr
    assert "Traceback" not in done.stderr
    assert not spec.with_suffix(".vtkhdf").exists()
