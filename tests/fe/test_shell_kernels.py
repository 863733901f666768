"""The matrices of shells come from their text in UFL, through FFCx and DOLFINx."""

import json
from pathlib import Path

import numpy as np
import pytest
from harness.processes import this_python
from samples.shell_specs import plate

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx.libraries import dolfinx
from plymotion.preprocess.shell.elements import pairs
from plymotion.preprocess.shell.elements.pairs import Choice
from plymotion.preprocess.shell.elements.single_cells import cell_table
from plymotion.preprocess.shell.model.shell_problem import ShellProblem

ROOT = Path(__file__).resolve().parent.parent.parent
BENDING = np.array([False, False, True, True, True, False])  # of a plate in z = 0


def dense(problem: ShellProblem) -> np.ndarray:
    return problem.K.toarray()


@pytest.fixture
def changed(monkeypatch):
    """Replace the text of a list, for the time of the test."""

    def change(kind: str, work) -> None:
        monkeypatch.setitem(pairs.WORKS, kind, work)
        pairs._compiled.cache_clear()

    yield change
    monkeypatch.undo()
    pairs._compiled.cache_clear()


def test_a_change_of_the_text_changes_the_stiffness(changed) -> None:
    spec = plate((3, 2), 0.01)
    before = dense(ShellProblem(spec))
    text = pairs.WORKS["plate"]

    def doubled(t, name: str) -> pairs.Work:
        work = text(t, name)
        return work._replace(pairs=[(2.0 * stress, strain) for stress, strain in work.pairs])

    changed("plate", doubled)
    after = dense(ShellProblem(spec))
    factor = np.where(np.tile(BENDING, len(before) // 6), 2.0, 1.0)
    expected = factor[:, None] * before
    assert np.abs(after - expected).max() < 1e-14 * np.abs(before).max()
    assert np.abs(after - before).max() > 0.0


@pytest.mark.parametrize("element", ["triangle", "quadrilateral"])
def test_dolfinx_assembles(element: str, monkeypatch) -> None:
    spec = plate((3, 2), 0.01)
    spec["mesh"]["element"] = element
    calls = []
    assemble = dolfinx.cpp.fem.petsc.assemble_matrix

    def counted(matrix, form, *rest):
        calls.append(form)
        return assemble(matrix, form, *rest)

    monkeypatch.setattr(dolfinx.cpp.fem.petsc, "assemble_matrix", counted)
    problem = ShellProblem(spec)
    assert problem.K.nnz > 0
    assert problem.M.nnz > 0
    assert len(calls) == 2
    monkeypatch.setattr(dolfinx.cpp.fem.petsc, "assemble_matrix", lambda *_: None)
    assert not ShellProblem(spec).K.toarray().any()


def test_the_preallocated_pattern_is_exact() -> None:
    """PETSc neither allocates more nor leaves room: each row has the blocks of its neighbours."""
    problem = ShellProblem(plate((5, 4), 0.01))
    cells, n = problem.mesh.cells, problem.mesh.n_node
    near = np.zeros((n, n), dtype=bool)
    for cell in cells:
        near[np.ix_(cell, cell)] = True
    assert np.array_equal(np.diff(problem.K.indptr), np.repeat(6 * near.sum(axis=1), 6))
    assert problem.K.has_sorted_indices


def test_data_of_other_cells_are_refused() -> None:
    """Before the call in C, which would read past them."""
    problem = ShellProblem(plate((3, 2), 0.01))
    region, kernel = problem.regions[0], pairs.stiffness_kernel(3, Choice())
    table = cell_table(region.geometry, region.stiffness, Choice())
    whole = fenicsx.Surface(problem.mesh.points_G, region.nodes)
    pattern = fenicsx.SurfacePattern([region.nodes], problem.mesh.n_node)
    for wrong in (table[:-1], table[:, :-1]):
        with pytest.raises(ValueError, match="data"):
            pattern.summed([(whole, kernel, wrong)])
        with pytest.raises(ValueError, match="data"):
            fenicsx.matrices(kernel, wrong, region.geometry.corners_G)
    with pytest.raises(ValueError, match="corners"):
        fenicsx.matrices(kernel, table, region.geometry.corners_G[:, :2])
    quads = pairs.stiffness_kernel(4, Choice())
    with pytest.raises(ValueError, match="corners"):
        pattern.summed([(whole, quads, table)])


@pytest.mark.one_end
def test_without_a_compiler_the_message_says_so(tmp_path) -> None:
    program = (
        "import sys\nfrom plymotion.preprocess.__main__ import main\nsys.exit(main(sys.argv[1:]))"
    )
    spec = tmp_path / "part.json"
    table = plate((3, 2), 0.01, supports={"root": {"at": "left", "fixed": "all"}})
    table["loads"] = {"down": {"tip": {"at": "right", "force": [0.0, 0.0, 1.0]}}}
    spec.write_text(json.dumps(table))
    cache = tmp_path / "cache"
    cache.mkdir(mode=0o700)
    environment = {"PYTHONPATH": str(ROOT), "CC": "/nowhere/cc", "PLYMOTION_CACHE": str(cache)}
    done = this_python("-c", program, "shell", spec, cwd=ROOT, more=environment)
    assert done.returncode == 2
    assert "no C compiler '/nowhere/cc'" in done.stderr
    assert "Traceback" not in done.stderr
    assert not spec.with_suffix(".vtkhdf").exists()
