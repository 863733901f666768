"""Killed while code is compiled: of the step loop, and of DOLFINx's forms."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from harness.hostile_profile import LONG, WAIT_S, count
from harness.struck_samples import number_of, project, struck

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
FORM = """
import sys
from plymotion.preprocess.fenicsx import libraries
import ufl
from mpi4py import MPI
mesh = libraries.dolfinx.mesh.create_unit_interval(MPI.COMM_SELF, 2)
make = getattr(libraries.dolfinx.fem, "functionspace", None) or libraries.dolfinx.fem.FunctionSpace
v = ufl.TestFunction(make(mesh, ("Lagrange", int(sys.argv[1]))))
libraries.dolfinx.fem.form(v * ufl.dx)
"""
LONG_ONLY = pytest.mark.skipif(LONG == 1, reason="takes half a minute of CPU: `make attack`")


@LONG_ONLY
@pytest.mark.parametrize(
    ("kind", "places"),
    [
        ("compiling", [200, 300, 300, 300, 200]),
        ("before", [8, 5, 5, 5, 5]),
        ("after", [8, 5, 5, 5, 5]),
    ],
)
def test_while_units_of_the_step_loop_are_compiled(tmp_path, kind, places):
    """In the code generator, and while units go to the cache; the next run goes on from there."""
    folder = project(tmp_path / "project")
    cache = tmp_path / "cache"
    words = ["run", str(folder / "build/runs/base.json"), "--quiet", "--out", str(tmp_path / "out")]
    more = {"PLYMOTION_COMPILED": "1", "PLYMOTION_CACHE": str(cache)}
    kept = 0
    # Each time some of 91 units and 2403 modules are left.
    names = ["SIGKILL", "SIGINT", "SIGTERM", "SIGHUP", "SIGKILL"]
    for place, name in zip(places, names, strict=True):
        done = struck(f"{kind} {name}", place, words, **more)
        assert "struck" in done.stderr, "nothing was compiled"
        number = number_of(name)
        right = done.returncode == (-9 if number == 9 else 128 + number)
        end = "traceback" if "Traceback" in done.stderr else "recovered" if right else "other"
        before, kept = kept, sum(1 for file in cache.rglob("[!.]*") if file.is_file())
        told = "in the code generator" if kind == "compiling" else "when a unit is kept"
        count(f"run: {name} {told}", end)
        assert end == "recovered", f"{done.returncode}: {done.stderr}"
        assert kept >= before
    assert kept, "what was compiled is lost"
    # A temporary file of an hour ago belongs to no process that still writes it.
    for file in cache.rglob(".new-*"):
        os.utime(file, (time.time() - 3601.0,) * 2)
    done = struck(f"{kind} none", 0, words, **more)
    assert done.returncode == 0, done.stderr
    assert not list(cache.rglob(".*"))


def _under_way(folder: Path) -> list[Path]:
    """Sources of elements and forms whose object code is not complete yet."""
    return [c for c in folder.glob("*.c") if not c.with_name(f"{c.name}.cached").exists()]


@LONG_ONLY
def test_while_dolfinx_compiles(repository, tmp_path, fenicsx):
    """Killed while FFCx and the C compiler are at work; the next process does it again."""
    environment = os.environ | {"PLYMOTION_CACHE": str(tmp_path), "PYTHONPATH": str(repository)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    forms, told = tmp_path / "forms/fenics", "preprocessor: SIGKILL while DOLFINx compiles a form"
    for power in range(1, 5):
        words = [fenicsx, "-c", FORM, str(power)]
        process = subprocess.Popen(words, env=environment, start_new_session=True)
        while process.poll() is None and not _under_way(forms):
            time.sleep(0.001)
        os.killpg(process.pid, signal.SIGKILL)  # the C compiler, too
        process.wait()
        assert _under_way(forms), "it came too late"
        again = subprocess.run(
            words, env=environment, capture_output=True, text=True, timeout=WAIT_S
        )
        whole = again.returncode == 0 and not _under_way(forms)
        end = "recovered" if whole else "traceback" if "Traceback" in again.stderr else "other"
        count(told, end)
        assert end == "recovered", again.stderr
