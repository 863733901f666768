"""A section, a shell, a solid on the ranks of an MPI job: parts of matrices, results, failures."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness.mpi_samples import of_ranks
from samples.section_specs import library_spec
from samples.shell_specs import CFRP, box, plate
from samples.solid_samples import WOUND

from plymotion.preprocess.__main__ import main
from plymotion.solver.package import ModalPackage, read_package
from plymotion.solver.package.section.section_file import read_section
from plymotion.solver.package.shell.shell_file import read_shell

CLOSE = 1e-8
BEAM = {"stiffness": np.diag([7e7, 3e7, 3e7, 5e2, 6e2, 6e2]).tolist(), "mass": np.eye(6).tolist()}
CLAMPED = {"root": {"at": "left", "fixed": "all"}}
PULL, PUSH = ({"x": {"tip": {"at": "right", "force": [f, 0.0, 10.0]}}} for f in (1e3, -1e3))

SECTIONS: dict[str, dict[str, Any]] = {
    "box": library_spec("box", {"width": 0.1, "height": 0.06, "wall": 0.004}, CFRP),
    "thin": library_spec("rectangle", {"width": 1.0, "height": 1e-4}, CFRP),
    "twisted": {
        **library_spec("rectangle", {"width": 0.1, "height": 0.05}, CFRP),
        "initial_curvature": [0.4, 0.0, 0.1],
    },
}
SHELLS: dict[str, dict[str, Any]] = {
    "linked": box(
        links={"tip": {"at": "tip", "kind": "average"}},
        loads={"a": {"f": {"at": "tip", "force": [1, 2, -3]}, "g": {"gravity": [0, 0, -9.8]}}},
        frequencies={"count": 4, "free": True},
    ),
    "stiffened": plate(
        (20, 6),
        0.004,
        1.0,
        0.3,
        stiffeners={"top": {"at": "top", "offset": [0.0, 0.02], **BEAM}},
        supports=CLAMPED,
        links={"end": {"at": "right", "kind": "rigid"}},
        loads={"pull": {"tip": {"at": "end", "force": [1e3, 0.0, 10.0]}}},
        frequencies={"count": 3, "prestress": "pull"},
    ),
    "buckling": plate((16, 6), 0.004, 1.0, 0.3, supports=CLAMPED, loads=PUSH, buckling={}),
    "quadrilaterals": plate((30, 8), 0.01, supports=CLAMPED, loads=PULL, frequencies={"count": 3}),
}
SHELLS["quadrilaterals"]["mesh"]["element"] = "quadrilateral"

BAR = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 0.1, 0.02, 0.01};
Mesh.CharacteristicLengthMax = 0.011;
Mesh.ElementOrder = 2;
Physical Volume("all") = {1};
"""
AXIS = {"point": [0.0, -0.02, 0.0], "direction": [0.0, 0.0, 1.0]}
LOADS = {
    "pulled": {"tip": {"at": "tip", "force": [1.0, 2.0, 3.0], "pressure": 1e5}},
    "own": {"weight": {"gravity": [0.0, 0.0, -9.8]}},
}


def solid(file: Path, **more: Any) -> dict[str, Any]:
    """A bar whose material is wound about an axis, with two interfaces."""
    file.write_text(BAR)
    places = (("root", 0.0, "rigid"), ("tip", 0.1, "average"))
    return {
        **{"body": "bar", "kind": "solid", "damping_ratio": 0.0},
        "solid": {
            "mesh": {"file": str(file), "unit": 1.0},
            "materials": {"wound": WOUND},
            "regions": {"all": {"material": "wound", "axis_about": AXIS}},
        },
        "interfaces": {
            name: {
                "plane": {"point": [x, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]},
                **{"link": link, "rotation_deg": [0.0, 0.0, 0.0]},
            }
            for name, x, link in places
        },
        "reference": {"kind": "mean-axis"},
        "modes": [{"kind": "lowest", "count": 3}],
        **more,
    }


def solids(folder: Path) -> dict[str, dict[str, Any]]:
    """A body with all that its matrices are summed for, and a solid that is analysed alone."""
    attached = {"kind": "attachment", "at": "tip", "directions": ["y", "z"]}
    return {
        "body": solid(
            folder / "bar.geo",
            reference={"kind": "clamped", "at": "root"},
            modes=[{"kind": "lowest", "count": 3}, attached],
            second_order=True,
        ),
        "alone": solid(
            folder / "bar.geo", analysis={"supports": ["root"], "loads": LOADS, "error": True}
        ),
    }


# What each rank has of a shell and of a section; sums over the ranks against the whole.
PARTS = """
import json, sys
from functools import partial
import numpy as np
from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx.team import Distribution
from plymotion.preprocess.section.space.layers import layup
from plymotion.preprocess.section.section_problem import section_problem
from plymotion.preprocess.parts import own as own_part
from plymotion.preprocess.products import BodyPackages
from plymotion.preprocess.shell.model.shell_problem import ShellProblem
from plymotion.preprocess.solid.model import Iterative, Mumps, SolidModel
from plymotion.preprocess.solid.solid_analysis import HeldSolid
from plymotion.preprocess.solid.solid_mesh import SolidError
from plymotion.preprocess.solid.solid_body import second_order_forces
from plymotion.solver.package.common.plain_data import SpecError

def solved(model, loads):
    "Frequencies, displacements, and forces of second order, by both solvers."
    for solver in (partial(Mumps), partial(Iterative, model.mesh.plain)):
        held = HeldSolid(model.body, model.links, ["root"], partial(solver, team=model.team))
        u = [held.case(each, model.unit_pressure).u.ravel() for each in loads.values()]
        yield held.hertz(3), *u, second_order_forces(model, np.stack(u, axis=1))

team, found = fenicsx.Team(fenicsx.MPI.COMM_WORLD), {}
specs, loads = json.load(open(sys.argv[1]))
for name, spec in specs.items():
    parts, results = [], []
    for own in (fenicsx.ALONE, team):
        if name == "solid":
            model = SolidModel(spec["solid"], spec["interfaces"], team=own)
            parts.append(own_part(model.body.K))
            results.append(list(solved(model, loads)))
        elif name == "shell":
            problem = ShellProblem(spec, name, own)
            parts.append(problem.freedom.reduced(problem.K))
        else:
            problem = section_problem(spec, name, 2, own)
            C = layup(spec, problem.mesh, problem.space, name).stiffness
            parts.append(problem.space.E(C[problem.space.own]))
            cells = len(problem.space.gradients)
    whole, part = parts
    rows = Distribution(team, part)
    matrix = rows.matrix(part, spd=False)
    X = np.random.default_rng(0).standard_normal((whole.shape[0], 2))
    product = team.total(part @ X)
    own = np.zeros((rows.n_own, 2))  # rows of the sum, in PETSc's order of unknowns
    for column in range(2):
        x, y = matrix.createVecs()
        x.array[:] = X[rows.rows, column]
        matrix.mult(x, y)
        own[:, column] = y.array
    found[name] = {
        "product": float(np.abs(product - whole @ X).max() / np.abs(whole @ X).max()),
        "rows": float(np.abs(rows.gathered(own) - whole @ X).max() / np.abs(whole @ X).max()),
        "of the rows": rows.n_own / rows.n,
        "of the entries": part.nnz / whole.nnz,
        "results": [
            [float(np.abs(a - b).max() / np.abs(a).max()) for a, b in zip(*pair, strict=True)]
            for pair in (zip(*results, strict=True) if results else ())
        ],
    }
found["refused"], absent = [], {"mesh": {"file": "absent.geo", "unit": 1.0}}
for make in (
    lambda: SolidModel(absent, {}, team=team),
    lambda: BodyPackages(None, team).analyse({"kind": "beam"}),
):
    try:
        make()
    except (SolidError, SpecError) as error:
        found["refused"].append(str(error))
found["of the cells"] = cells / problem.mesh.cells.n_cell
# 300 of 900 negative eigenvalues; after 300 unknowns of few neighbours, all others are one front
random, row = np.random.default_rng(0), np.arange(900)
A = np.triu(random.standard_normal((900, 900)), 1)
A[:300] *= random.random((300, 900)) < 0.1
A[:300, :300] = 0.0
A += A.T + np.diag(np.where(row % 3, 1e3, -1e3))
own = (row % 2 == team.rank).astype(float)
found["negative"] = fenicsx.negative_pivots(A * 0.5 * np.add.outer(own, own), team)
everything = team.comm.gather(found)
if team.rank == 0:
    print(json.dumps(everything))
"""

# Rank 1 fails where the other one waits for its rows.
FAILS = """
import sys
from plymotion.preprocess.__main__ import main
from plymotion.preprocess.fenicsx import team

def fails(self, part, **options):
    raise MemoryError("no memory for the rows")

team.AFTER_ERROR = 1.0
if team.Ranks().rank == 1:
    team.Distribution.matrix = fails
sys.exit(main(sys.argv[1:]))
"""

# Several commands one after the other: each job of ranks that begins takes seconds.
COMMANDS = """
import json, sys
from plymotion.preprocess.__main__ import main

sys.exit(max(main(words) for words in json.load(open(sys.argv[1]))))
"""
RUNS: dict[str, tuple[str, dict[str, dict[str, Any]], tuple[str, ...]]] = {
    "sections": ("section", SECTIONS, ()),
    "refined": ("section", {"box": SECTIONS["box"]}, ("--accuracy", "1e-4")),
    "shells": ("shell", SHELLS, ()),
    "solids": ("body", {}, ()),
}


def files(folder: Path, specs: dict[str, dict[str, Any]]) -> list[Path]:
    folder.mkdir(exist_ok=True)
    made = [folder / f"{name}.json" for name in specs]
    for file, spec in zip(made, specs.values(), strict=True):
        file.write_text(json.dumps(spec))
    return made


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of each run, with results of two ranks in `together`, of this process in `alone`."""
    root = tmp_path_factory.mktemp("ranks")
    lines: dict[str, list[list[str]]] = {"alone": [], "together": []}
    told = []
    for name, (command, specs, options) in RUNS.items():
        made = files(root / name, specs or solids(root))
        told += [f"[{k}/{len(made)}] {file.stem}: " for k, file in enumerate(made, 1)]
        for ranks, commands in lines.items():
            to = "--out-dir", str(root / name / ranks)
            commands.append([command, *map(str, made), *to, *options])
    assert [main(words) for words in lines["alone"]] == [0] * len(RUNS)
    (root / "commands.json").write_text(json.dumps(lines["together"]))
    done = of_ranks(2, "-c", COMMANDS, root / "commands.json")
    assert done.returncode == 0, done.stderr
    printed = done.stdout.splitlines()
    assert len(printed) == len(told)
    assert all(line.startswith(begin) for line, begin in zip(printed, told, strict=True)), printed
    return root


def test_ranks_have_parts_of_matrices_and_rows_of_their_sum(tmp_path: Path) -> None:
    bar = solid(tmp_path / "bar.geo")
    specs = {"solid": bar, "shell": SHELLS["stiffened"], "section": SECTIONS["box"]}
    file = tmp_path / "specs.json"
    file.write_text(json.dumps([specs, LOADS]))
    done = of_ranks(2, "-c", PARTS, file)
    assert done.returncode == 0, done.stderr
    ranks = json.loads(done.stdout)
    for name in specs:
        shares = [rank[name]["of the rows"] for rank in ranks]
        assert sum(shares) == pytest.approx(1.0, abs=1e-12)
        for rank in ranks:
            assert rank[name]["product"] < 1e-13
            assert rank[name]["rows"] < 1e-13
            assert 0.3 < rank[name]["of the rows"] < 0.7
            assert rank[name]["of the entries"] < 0.65
            assert np.max(rank[name]["results"], initial=0.0) < CLOSE
            assert rank["of the cells"] == pytest.approx(0.5, abs=0.01)
            assert rank["refused"] == [
                "mesh.file = 'absent.geo': no such file",
                "mpirun started 2 processes: expected one, as ranks share no body of kind 'beam'",
            ]
            assert rank["negative"] == 300


@pytest.mark.one_end
def test_sections_by_two_ranks(both: Path) -> None:
    for name in SECTIONS:
        files = (both / "sections" / ranks / f"{name}.vtkhdf" for ranks in ("alone", "together"))
        one, two = map(read_section, files)
        size = np.sqrt(np.diag(one.K))
        limit = CLOSE * np.outer(size, size)
        measured = [each.provenance["round_off"] for each in (one, two)]  # of a thin wall
        if None not in measured:
            limit += 2.0 * max(measured) * np.outer(size, size)
        assert (np.abs(two.K - one.K) <= limit).all(), name
        np.testing.assert_allclose(two.M, one.M, rtol=1e-12, atol=1e-12 * np.abs(one.M).max())
        assert two.error_estimate is not None
        assert two.provenance["ranks"] == 2
        assert len(two.recovery.points) == len(one.recovery.points)
        if name == "box":
            worst = np.abs(two.recovery.strain_M - one.recovery.strain_M).max()
            assert worst < CLOSE * np.abs(one.recovery.strain_M).max()


@pytest.mark.one_end
def test_refined_section_by_two_ranks(both: Path) -> None:
    """With hanging nodes."""
    files = (both / "refined" / ranks / "box.vtkhdf" for ranks in ("alone", "together"))
    one, two = map(read_section, files)
    assert len(one.provenance["refinements"]) > 1
    assert one.provenance["dofs"] == two.provenance["dofs"]
    size = np.sqrt(np.diag(one.K))
    assert np.abs((two.K - one.K) / np.outer(size, size)).max() < CLOSE


def numbers(package: ModalPackage) -> list[Any]:
    """What is summed over the ranks or follows from sums."""
    sums, tip, told = package.invariants, package.interfaces[1], package.provenance["solid"]
    found = [package.stiffness, package.compliance, sums.T00_B, sums.T01_B, sums.T11_B, tip.phi_B]
    if (bent := package.second_order) is not None:
        found += [bent.Z0_B, bent.Z1_B, bent.G4, tip.H_B]
    else:
        found += [told[key] for key in ("held_hz", "free_error", "held_error")]
        found.append(told["cases"]["own"]["reactions"]["root"])
    return found


@pytest.mark.one_end
def test_solids_by_two_ranks(both: Path) -> None:
    for name in ("body", "alone"):
        files = (both / "solids" / ranks / f"{name}.vtkhdf" for ranks in ("alone", "together"))
        one, two = map(read_package, files)
        assert two.provenance["ranks"] == 2
        np.testing.assert_allclose(two.frequencies[:3], one.frequencies[:3], rtol=1e-10)
        for a, b in zip(numbers(one), numbers(two), strict=True):
            assert np.abs(np.subtract(a, b)).max() < CLOSE * np.abs(a).max(), name


@pytest.mark.one_end
def test_shells_by_two_ranks(both: Path) -> None:
    folder = both / "shells"
    for name in SHELLS:
        files = (folder / ranks / f"{name}.vtkhdf" for ranks in ("alone", "together"))
        one, two = map(read_shell, files)
        pairs = [
            (one.cases.displacements_G, two.cases.displacements_G),
            (one.cases.resultants_E, two.cases.resultants_E),
            (one.cases.reactions_G, two.cases.reactions_G),
        ]
        if one.modes is not None:
            assert two.modes is not None
            pairs.append((one.modes.frequencies, two.modes.frequencies))
            if name == "linked":  # a free body
                pairs.append((one.modes.shapes_G[6:], two.modes.shapes_G[6:]))
        assert one.provenance["ranks"] == 1
        assert two.provenance["ranks"] == 2
        if one.buckling is not None:
            assert two.buckling is not None
            pairs.append((one.buckling.factors, two.buckling.factors))
        for a, b in pairs:
            limit = 1e-9 if name == "linked" else CLOSE
            assert np.abs(a - b).max() < limit * np.abs(a).max(), name
    out = "--out-dir", str(folder / "alone")
    assert main(["shell", str(folder / "linked.json"), *out, "--json"]) == 0


def test_a_failing_rank_ends_all(tmp_path: Path) -> None:
    (file,) = files(tmp_path, {"box": SHELLS["linked"]})
    done = of_ranks(2, "-c", FAILS, "shell", file)
    assert done.returncode == 2
    told = "rank 1: error: no memory for the rows; the job is aborted"
    assert done.stderr.count(told) == 1, done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("*.vtkhdf*"))
