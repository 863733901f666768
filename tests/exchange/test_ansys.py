"""Files of ANSYS through its library: the samples that come with it; it cannot be run here."""

import importlib
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from samples.exchange_routes import PROGRAMS
from samples.exchange_samples import bar, request

from plymotion.preprocess.exchange import from_matrices
from plymotion.preprocess.exchange.formats.ansys import body_of, matrices, mesh_of
from plymotion.preprocess.exchange.free_body import Cells
from plymotion.preprocess.exchange.import_table import Files
from plymotion.preprocess.exchange.reduce import reduce_body
from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.math.arrays import Array
from plymotion.solver.package import read_package, validate
from plymotion.solver.package.body.invariants import rigid_motions

IMPORT_FILE = """\
format = 1
body = "bar"
from = "{source}"
units = {{ length = "mm", mass = "g", time = "s" }}
reference = {{ kind = "mean-axis" }}
modes = [{{ kind = "lowest", count = 5 }}]

[files]
{files}

[interfaces]
end = {{ box = [[-9, -9, 4.999], [9, 9, 5.001]], link = "average" }}
"""


@pytest.fixture(scope="module")
def samples() -> Iterator[Path]:
    """Folder of the library's sample files; the library can be imported meanwhile."""
    folder = PROGRAMS / "python" / "ansys" / "mapdl" / "reader" / "examples"
    if not folder.is_dir():
        pytest.skip("ansys-mapdl-reader is not installed: make test-exchange downloads it")
    pytest.importorskip("pyvista")
    sys.path.insert(0, str(PROGRAMS / "python"))
    try:
        importlib.import_module("ansys.mapdl.reader")
        yield folder
    finally:
        sys.path.remove(str(PROGRAMS / "python"))


def test_rows_belong_to_the_nodes_of_the_result(samples: Path) -> None:
    """A rigid motion meets no force in the rows of nodes away from the supports."""
    dofs, K, _ = matrices(samples / "file.full")
    ids, nodes, cells, _ = mesh_of(samples / "file.rst")
    K = sp.csr_matrix(K + sp.triu(K, 1).T)
    row = np.searchsorted(ids, dofs[:, 0])
    R = rigid_motions(nodes)[row, dofs[:, 1]]
    away = nodes[row, 2] > 0.6  # elements are 0.5 long
    assert away.sum() > 700
    force = np.abs(K @ R)
    assert force[away].max() < 1e-9 * (abs(K) @ np.abs(R)).max()
    assert force[~away].max() > 0.1 * np.abs(K).max()
    assert set(cells.types.tolist()) == {25}
    # Midside nodes lie between their corners: the order is that of VTK.
    for kind, rows in cells.each()[:3]:
        assert kind == 25
        x = nodes[rows]
        np.testing.assert_allclose(x[8], 0.5 * (x[0] + x[1]), atol=1e-12)
        np.testing.assert_allclose(x[16], 0.5 * (x[0] + x[4]), atol=1e-12)


def test_matrices_of_a_held_body_are_refused(
    samples: Path,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The sample is held at one end: 21 nodes have lost their mass."""
    monkeypatch.setenv("PYTHONPATH", str(PROGRAMS / "python"))
    for name in ("file.full", "file.rst"):
        shutil.copy(samples / name, tmp_path)
    files = 'full = "file.full"\nrst = "file.rst"'
    (tmp_path / "bar.toml").write_text(IMPORT_FILE.format(source="ansys", files=files))
    out = tmp_path / "bar.vtkhdf"
    assert main(["import", str(tmp_path / "bar.toml"), "-o", str(out), "--quiet"]) == 2
    told = capfd.readouterr().err
    assert "63 degrees of freedom are held, first node 1, direction x" in told
    assert "expected matrices of the free body" in told
    assert not out.exists()


def upper(A: sp.spmatrix) -> sp.csr_matrix:
    return sp.csr_matrix(sp.triu(A))


def test_a_free_body_is_that_of_its_matrices(tmp_path: Path) -> None:
    """As the library hands matrices over: upper triangles, rows in any order, directions from 0."""
    body = bar()
    shuffled = np.random.default_rng(2).permutation(len(body.dofs))
    dofs = np.array(body.dofs)[shuffled] - [0, 1]
    K, M = (upper(A[shuffled][:, shuffled]) for A in (body.K, body.M))
    ids = np.arange(1, len(body.nodes) + 1)
    mesh = ids, body.nodes, Cells.points(len(body.nodes))
    files = Files({}, tmp_path, "bar.toml")
    found = body_of(files, tmp_path / "file.full", (dofs, K, M), mesh)
    units = {"length": "m", "mass": "kg", "time": "s"}
    own = from_matrices(body.M, body.K, body.nodes, body.dofs, **request())
    package = reduce_body(found, {**request(), "units": units})
    np.testing.assert_allclose(package.frequencies, own.frequencies, rtol=1e-8)


@pytest.mark.parametrize(
    ("change", "message"),
    [("temperature", "no displacements; expected a structural"), ("held", "3 degrees of freedom")],
)
def test_other_matrices_are_refused(tmp_path: Path, change: str, message: str) -> None:
    body = bar()
    dofs = np.array(body.dofs) - [0, 1]
    K, M = upper(body.K), upper(body.M)
    if change == "temperature":
        dofs[7, 1] = 19
    else:
        free = sp.diags((dofs[:, 0] != 5).astype(float))
        K, M = (sp.csr_matrix(free @ A @ free) for A in (K, M))
        K.eliminate_zeros()
    ids = np.arange(1, len(body.nodes) + 1)
    mesh = ids, body.nodes, Cells.points(len(body.nodes))
    with pytest.raises(InputError, match=message):
        body_of(Files({}, tmp_path, "bar.toml"), tmp_path / "a.full", (dofs, K, M), mesh)


def nodal_masses(nodes: Array, total: float) -> Array:
    """Masses of the nodes of the sample, 8-node corners and midsides of 2 x 2 x 10 elements."""
    on_edge = np.abs(nodes[:, :2] - 0.5) > 0.49
    share = np.where(np.isclose(nodes % 0.5, 0.0), 1.0, 2.0).prod(axis=1)
    share /= 2.0 ** on_edge.sum(axis=1)
    share[np.isclose(nodes[:, 2] % 5.0, 0.0)] /= 2.0
    return share * (total / share.sum())


def test_modes_of_a_result(
    samples: Path,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Five vibrations of the free bar, with masses of the nodes."""
    monkeypatch.setenv("PYTHONPATH", str(PROGRAMS / "python"))
    shutil.copy(samples / "file.rst", tmp_path)
    ids, nodes, _, result = mesh_of(samples / "file.rst")
    # 1 x 1 x 5 mm of 7.85 mg/mm3
    masses = nodal_masses(nodes, 5 * 7.85e-3)
    rows = [f"{label},{mass!r}" for label, mass in zip(ids, masses.tolist(), strict=True)]
    (tmp_path / "masses.csv").write_text("node,mass\n" + "\n".join(rows) + "\n")
    files = 'rst = "file.rst"\nmasses = "masses.csv"'
    (tmp_path / "bar.toml").write_text(IMPORT_FILE.format(source="ansys-modes", files=files))
    out = tmp_path / "bar.vtkhdf"
    code = main(["import", str(tmp_path / "bar.toml"), "-o", str(out), "--quiet"])
    assert code == 0, capfd.readouterr().err
    package = read_package(out)
    hertz = package.frequencies / (2.0 * np.pi)
    np.testing.assert_allclose(hertz, result.time_values[:5], rtol=1e-9)
    assert not [found for found in validate(out) if found.level == "error"]
    assert package.invariants.mass == pytest.approx(5 * 7.85e-6, rel=1e-9)


def test_without_the_library_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ansys.mapdl.reader", None)  # as if not installed
    with pytest.raises(InputError, match=r"needs the Python package ansys-mapdl-reader .*pip inst"):
        matrices(tmp_path / "file.full")


def test_another_file_is_no_matrix(samples: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"expected matrices \.full of ANSYS, found Result"):
        matrices(samples / "file.rst")
    (tmp_path / "file.full").write_bytes(b"\0" * 1000)
    with pytest.raises(InputError, match=r"expected matrices \.full of ANSYS"):
        matrices(tmp_path / "file.full")
