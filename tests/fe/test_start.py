"""What the preprocessor loads: parts of FEniCSx that an analysis needs, none to find no work."""

import json
from pathlib import Path
from typing import Any

import pytest
from harness.processes import this_python
from samples.section_specs import rectangle_spec
from samples.shell_specs import METAL, plate

ROOT = Path(__file__).resolve().parent.parent.parent
BUILD_AND_LIST = """
import sys
from plymotion.preprocess.__main__ import main
assert main(sys.argv[1:]) == 0
print(*sys.modules)
"""
DOLFINX = {"dolfinx", "ufl", "ffcx", "pkg_resources"}
STACK = {"gmsh", "mpi4py", "petsc4py.PETSc", "slepc4py.SLEPc", "basix", "scipy"} | DOLFINX

SECTION = rectangle_spec(2.0, 1.0, METAL)
SHELL = plate((4, 2), 0.01, supports={"root": {"at": "left", "fixed": "all"}})
SHELL["mesh"]["element"] = "quadrilateral"
SHELL["loads"] = {"down": {"tip": {"at": "right", "force": [0.0, 0.0, 1.0]}}}

pytestmark = pytest.mark.one_end


def loaded(command: str, spec: Path) -> set[str]:
    """Modules of a process that makes the file of a specification."""
    done = this_python(
        "-c", BUILD_AND_LIST, command, spec, cwd=ROOT, more={"PYTHONPATH": str(ROOT)}
    )
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


@pytest.mark.parametrize(
    ("command", "table", "used", "unused"),
    [
        ("section", SECTION, {"gmsh", "dolfinx", "ufl"}, {"slepc4py.SLEPc", "scipy.spatial"}),
        ("shell", SHELL, {"gmsh", "dolfinx", "ufl", "ffcx"}, {"slepc4py.SLEPc"}),
    ],
    ids=["section", "shell"],
)
def test_parts_of_fenicsx(
    command: str, table: dict[str, Any], used: set[str], unused: set[str], tmp_path: Path
) -> None:
    spec = tmp_path / "part.json"
    spec.write_text(json.dumps(table))
    first = loaded(command, spec)
    assert used | {"petsc4py.PETSc"} <= first
    assert first & unused == set()
    assert spec.with_suffix(".vtkhdf").is_file()
    again = loaded(command, spec)
    assert again & STACK == set(), "a file that is up to date needs no part of FEniCSx"
