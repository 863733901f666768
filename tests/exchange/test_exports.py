"""Packages in the formats of other codes, read again."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.dmig_cards import read_dmig
from samples.exchange_samples import bar, exported, request

from plymotion.preprocess.exchange import from_matrices
from plymotion.preprocess.exchange.__main__ import main
from plymotion.preprocess.exchange.formats.dmig import superelement
from plymotion.solver.package import ModalPackage, read_package, write_package


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    body = bar()
    cells = (body.cells + 1).tolist()
    package = from_matrices(
        body.M, body.K, body.nodes, body.dofs, cells=cells, damping_ratio=0.01, **request()
    )
    file = tmp_path_factory.mktemp("export") / "arm.vtkhdf"
    write_package(file, package)
    return file


@pytest.fixture(scope="module")
def package(file: Path) -> ModalPackage:
    return read_package(file)


def test_med_keeps_every_digit(file: Path, package: ModalPackage, tmp_path: Path) -> None:
    out = exported(file, "med", tmp_path / "arm.med")
    with h5py.File(out) as med:
        mesh = med["ENS_MAA/arm/-0000000000000000001-0000000000000000001"]
        points = mesh["NOE/COO"][()].reshape(3, -1).T
        np.testing.assert_array_equal(points, package.nodes_B)
        np.testing.assert_array_equal(mesh["NOE/NUM"][()], package.node_ids)
        steps = list(med["CHA/DEPL"].values())
        assert len(steps) == package.n_mode
        for step, shape, w in zip(steps, package.shapes_B, package.frequencies, strict=True):
            values = step["NOE/MED_NO_PROFILE_INTERNAL/CO"][()].reshape(6, -1).T
            np.testing.assert_array_equal(values, shape)
            assert step.attrs["PDT"] == w / (2.0 * np.pi)


def test_meshio_reads_the_med_file(file: Path, package: ModalPackage, tmp_path: Path) -> None:
    """MED numbers the first face of a hexahedron the other way round."""
    import meshio

    mesh = meshio.read(exported(file, "med", tmp_path / "arm.med"))
    np.testing.assert_array_equal(mesh.points, package.nodes_B)
    (block,) = mesh.cells
    own = package.connectivity.reshape(-1, 8)
    np.testing.assert_array_equal(block.data, own[:, [0, 3, 2, 1, 4, 7, 6, 5]])


def test_dmig_keeps_its_digits(file: Path, package: ModalPackage, tmp_path: Path) -> None:
    out = exported(file, "dmig", tmp_path / "arm.bdf")
    assert max(map(len, out.read_text().splitlines())) <= 72
    found = read_dmig(out)
    K, M, points = superelement(package)
    for name, exact in (("KAAX", K), ("MAAX", M)):
        labels, A = found[name]
        assert len(labels) == 12 + points
        assert np.abs(A.toarray() - exact).max() <= 5e-10 * np.abs(exact).max()
        assert (np.abs(A.toarray() - exact) <= 5.1e-10 * np.abs(exact)).all()


def test_dmig_is_the_same_free_body(package: ModalPackage) -> None:
    """Six rigid motions, then the frequencies of the free reduced body."""
    from plymotion.solver.package.body.invariants import free_body_mass

    K, M, _ = superelement(package)
    m = package.n_mode
    free = np.zeros((6 + m, 6 + m))
    free[6:, 6:] = package.stiffness
    shift = 1e6
    found, exact = (
        1.0 / np.linalg.eigvals(np.linalg.solve(k + shift * mass, mass)).real - shift
        for k, mass in ((K, M), (free, free_body_mass(package)))
    )
    np.testing.assert_allclose(np.sort(found)[6:12], np.sort(exact)[6:12], rtol=1e-6)
    assert np.abs(np.sort(found)[:6]).max() < 1e-3


def test_dmig_needs_independent_interfaces(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    body = bar()
    package = from_matrices(
        body.M, body.K, body.nodes, body.dofs, **request(modes=[{"kind": "lowest", "count": 3}])
    )
    write_package(tmp_path / "few.vtkhdf", package)
    out = tmp_path / "few.bdf"
    assert main(["export", str(tmp_path / "few.vtkhdf"), "--to", "dmig", "-o", str(out)]) == 2
    assert "in 9 of 12 independent ways" in capsys.readouterr().err
    assert not out.exists()
