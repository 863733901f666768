"""What each half may import: checked in a fresh interpreter and by import-linter."""

import ast
import importlib
import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from harness.processes import this_python
from samples.case_samples import case_runs

from plymotion.solver.inputs.case.record import seal
from plymotion.solver.inputs.case.tables.schema import resolved

ROOT = Path(__file__).parents[2]
FE_MODULES = {"dolfinx", "petsc4py", "slepc4py", "mpi4py", "gmsh", "basix", "ufl", "ffcx"}

IMPORT_ALL = """
import importlib, pkgutil, sys
package = importlib.import_module(sys.argv[1])
for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
    if not module.name.endswith("__main__"):
        importlib.import_module(module.name)
print(*sys.modules)
"""


def modules_after_importing(package: str, repository: Path) -> set[str]:
    """sys.modules of a fresh interpreter that imported all modules of a package."""
    command = [sys.executable, "-c", IMPORT_ALL, package]
    done = subprocess.run(command, capture_output=True, text=True, cwd=repository)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def test_whole_solver_loads_no_fe_code(repository: Path) -> None:
    loaded = modules_after_importing("plymotion.solver", repository)
    on_disk = {
        ".".join(("plymotion", *path.relative_to(repository).with_suffix("").parts))
        for path in (repository / "solver").rglob("*.py")
        if not path.stem.startswith("__")
    }
    assert on_disk <= loaded, "some modules were not imported by this test"
    assert not {name.split(".")[0] for name in loaded} & FE_MODULES
    assert not {name for name in loaded if name.startswith("plymotion.preprocess")}


def test_package_format_needs_numpy_and_h5py_only(repository: Path) -> None:
    loaded = {
        name.split(".")[0]
        for name in modules_after_importing("plymotion.solver.package", repository)
    }
    assert "numpy" in loaded
    assert not loaded & (FE_MODULES | {"pydantic", "numba", "matplotlib", "tqdm", "pyvista"})


def bare_imports(source: str) -> list[str]:
    """Absolute imports of a half by its folder's name."""
    if not re.search(r"[\s,](solver|preprocess)\b", source):
        return []  # the name follows a space or a comma; parsing takes longer
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.append(node.module)
    return [name for name in found if name.split(".")[0] in {"solver", "preprocess"}]


@pytest.mark.parametrize("half", ["preprocess", "solver"])
def test_no_half_is_imported_by_its_bare_name(repository: Path, half: str) -> None:
    # It would be a second copy of the module, with a state of its own.
    for path in (repository / half).rglob("*.py"):
        assert bare_imports(path.read_text("utf-8")) == [], path


def test_bare_names_are_found() -> None:
    source = "import solver.package\nfrom preprocess import beam\nfrom . import solver\n"
    assert bare_imports(source) == ["solver.package", "preprocess"]


def copy_of_the_code(repository: Path, folder: Path) -> None:
    """The code laid out as installed, to plant forbidden imports in."""
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(repository / "plymotion", folder / "plymotion", ignore=ignore)
    for half in ("preprocess", "solver"):
        shutil.copytree(repository / half, folder / "plymotion" / half, ignore=ignore)
    shutil.copy(repository / "pyproject.toml", folder)


def lint(folder: Path) -> subprocess.CompletedProcess[str]:
    """import-linter on such a folder, its own modules first on the path."""
    program = "from importlinter.cli import lint_imports_command as c; c()"
    return this_python("-c", program, "--no-cache", cwd=folder, env={"PYTHONPATH": str(folder)})


PLANTED = [  # folder, forbidden import, contract that it breaks
    ("solver", "import dolfinx", "solver"),
    ("solver", "from ..preprocess import beam", "solver"),
    ("solver", "def f():\n    import gmsh", "solver"),
    ("preprocess", "from ..solver import dynamics", "preprocess"),
    ("preprocess", "import pydantic", "preprocess-light"),
    ("preprocess", "from petsc4py import PETSc", "fenicsx"),
    ("solver/dynamics/elements", "from .. import analysis", "dynamics"),
    ("solver/math", "from .. import package", "layers"),
    ("solver/integrators/generic", "from ... import dynamics", "integrators"),
    ("solver/package", "import scipy", "package"),
    ("solver/report", "from plymotion.api import case", "python"),
    ("api", "from ..solver.commands import parser", "api"),
]


def test_import_linter_sees_both_halves(repository: Path, tmp_path: Path) -> None:
    copy_of_the_code(repository, tmp_path)
    before = lint(tmp_path)
    assert before.returncode == 0, before.stdout + before.stderr
    for number, (folder, statement, _) in enumerate(PLANTED):
        text = f'"""An import that is not allowed."""\n\n{statement}\n'
        (tmp_path / "plymotion" / folder / f"planted_{number}.py").write_text(text)
    after = lint(tmp_path)
    assert after.returncode == 1, after.stdout + after.stderr
    # Long names are wrapped in the output: compare words. The chains of each contract follow.
    verdicts, _, chains = " ".join(after.stdout.split()).partition("Broken contracts")
    for number, (_, statement, contract) in enumerate(PLANTED):
        name = names(repository)[contract]
        assert f"{name} BROKEN" in verdicts, after.stdout
        part = re.split("-{20,}", chains.partition(name)[2])[1]
        assert f"planted_{number} " in part, f"{statement}: {part}"


def names(repository: Path) -> dict[str, str]:
    """Contract id -> its name, from pyproject.toml."""
    table = tomllib.loads((repository / "pyproject.toml").read_text("utf-8"))
    return {entry["id"]: entry["name"] for entry in table["tool"]["importlinter"]["contracts"]}


def test_each_contract_is_shown_to_bite(repository: Path) -> None:
    assert {contract for _, _, contract in PLANTED} == set(names(repository))


RUN_AND_LIST = """
import contextlib, io, sys
from plymotion.solver.__main__ import main
with contextlib.redirect_stdout(io.StringIO()):
    code = main(["run", *sys.argv[1:], "--quiet"])
assert code == 0, code
frozen = {
    f"frozen:{kind.__name__}"
    for module in [*sys.modules.values()]
    for kind in vars(module).values()
    if isinstance(kind, type)
    and getattr(getattr(kind, "__dataclass_params__", None), "frozen", False)
}
print(*sys.modules, *frozen)
"""
# Their values are compared, or keys of tables; others are a `record`, which takes a third to make.
FROZEN = {"Node", "NamedCurve", "Orthotropic", "Ply", "ShellPly", "YieldStrength"}
UNUSED = {
    *(
        "inputs.case.load",
        "inputs.case.messages",
        "integrators.force_variation",
        "integrators.expression_breaks",
    ),
    *("mechanism.rotor", "run.error_bars", "signals.sections", "signals.strength"),
}


def test_a_run_imports_what_it_uses(repository: Path, tmp_path: Path) -> None:
    """Neither figures nor SciPy, no models of a checked file, no compiler if the cache is full.

    No program is started either: importing h5py would ask one for the name of the processor.
    """
    runs = case_runs(repository, "double-pendulum", tmp_path / "build")
    file = runs / "isotropic.json"
    spec = json.loads(file.read_text())
    spec["mechanism"]["solver"] |= {"t_end": 0.002, "integrator": "radau"}
    spec["checked"] = seal(resolved(spec["mechanism"], str(file)))
    file.write_text(json.dumps(spec))
    command = [sys.executable, "-c", RUN_AND_LIST, str(file)]
    for _ in range(2):  # the first one may compile
        done = subprocess.run(command, capture_output=True, text=True, cwd=repository)
        assert done.returncode == 0, done.stderr
    loaded = set(done.stdout.split())
    assert not loaded & {"scipy", "pydantic", "matplotlib", "numba", "tqdm", "meshio", "pyvista"}
    assert not loaded & {"numpy.ma", "subprocess", "multiprocessing", "socket", "difflib"}
    assert not loaded & {"shutil", "tempfile", "random", "numpy.random"}
    assert "plymotion.solver.report" not in loaded
    assert sorted({f"plymotion.solver.{name}" for name in UNUSED} & loaded) == []
    frozen = {name.removeprefix("frozen:") for name in loaded if name.startswith("frozen:")}
    assert frozen == FROZEN
    words = ["modes", str(file), "--shapes", "0", "--out", str(tmp_path)]
    done = subprocess.run(
        [sys.executable, "-c", COMMAND_AND_LIST, *words],
        capture_output=True,
        text=True,
        cwd=repository,
    )
    assert done.returncode == 0, done.stderr
    assert not set(done.stdout.split()) & {"pydantic", "scipy.interpolate", "scipy.optimize"}


WITHOUT_RARE_PARTS_OF_NUMPY = """
import sys
import numpy as np
from plymotion.solver.integrators.step_loop import _among
from plymotion.solver.math.laws import ramp
from plymotion.solver.strength.search import Points, governing_points
none = Points(np.zeros((0, 6, 6)), np.zeros(0, dtype=int), {})
assert not governing_points(none, np.zeros((1, 6, 2)), np.zeros((3, 2))).size
found = _among(np.array([0.0, 0.5, 2.0]), np.array([2.0, 1.0, 0.5]))
assert found.tolist() == [False, True, True], found
assert not _among(np.ones(2), np.zeros(0)).any()
ramp(6.0, 15.0, sine=True)
assert not {"numpy.ma", "numpy.polynomial"} & {*sys.modules}
"""


def test_beams_of_given_matrices_stops_and_ramps_import_little(repository: Path) -> None:
    """Some functions of NumPy on sets import numpy.ma, which takes 6 ms."""
    command = [sys.executable, "-c", WITHOUT_RARE_PARTS_OF_NUMPY]
    done = subprocess.run(command, capture_output=True, text=True, cwd=repository)
    assert done.returncode == 0, done.stderr


COMMAND_AND_LIST = """
import contextlib, io, sys
from plymotion.solver.__main__ import main
with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
    code = main(sys.argv[1:])
    assert code == 0, code
print(*sys.modules)
"""
DRAWING = {
    "matplotlib",
    "tqdm",
    "numba",
    "meshio",
    "pyvista",
    "plymotion.solver.report.report_page",
}
NUMBERS = {"numpy", "h5py", "scipy", "pydantic"}
BODIES = {"plymotion.solver.package.body.package_file", "plymotion.solver.package.validation"}
DESCRIPTION = {"scipy", "plymotion.solver.inputs.case.load", "plymotion.solver.dynamics"}
STARTS = [  # a command, what it must not load
    ("--help", DRAWING | NUMBERS),
    ("run --help", DRAWING | NUMBERS),
    ("sweep --help", DRAWING | NUMBERS),
    ("check cases/slider-crank/case.toml", DRAWING | BODIES | {"scipy"}),
    ("section cases/sections/tube.toml --check --out", DRAWING | BODIES | DESCRIPTION),
    (
        "shell cases/shells/box-beam.toml --check --out",
        DRAWING | BODIES | DESCRIPTION | {"plymotion.solver.inputs.section.description"},
    ),
]


@pytest.mark.parametrize(("words", "unused"), STARTS, ids=[words for words, _ in STARTS])
def test_a_command_loads_what_it_uses(
    repository: Path, tmp_path: Path, words: str, unused: set[str]
) -> None:
    """Each of these modules takes a command as long as all that it does."""
    command = [sys.executable, "-c", COMMAND_AND_LIST, *words.split()]
    command += [str(tmp_path)] if words.endswith("--out") else []
    done = subprocess.run(command, capture_output=True, text=True, cwd=repository)
    assert done.returncode == 0, done.stderr
    assert not set(done.stdout.split()) & unused


def test_exchange_with_other_codes_needs_no_fe_code(repository: Path) -> None:
    loaded = {
        name.split(".")[0]
        for name in modules_after_importing("plymotion.preprocess.exchange", repository)
    }
    assert {"numpy", "scipy", "h5py"} <= loaded
    assert not loaded & (FE_MODULES | {"pydantic", "numba", "matplotlib", "meshio", "pyvista"})


@pytest.mark.parametrize("file", sorted((ROOT / "benchmarks").glob("*.py")), ids=lambda f: f.stem)
def test_benchmarks_import_what_exists(file: Path) -> None:
    """Names that scripts of benchmarks/ take from the solver: these scripts run seldom."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("plymotion.solver"):
            module = importlib.import_module(node.module or "")
            for alias in node.names:
                if not hasattr(module, alias.name):
                    importlib.import_module(f"{node.module}.{alias.name}")
