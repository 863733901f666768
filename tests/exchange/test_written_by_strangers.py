"""The writer of docs/format.md, which needs h5py and NumPy only, run as a test."""

import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.linalg
from samples.exchange_samples import SIZE, bar

from plymotion.solver.package import read_package, validate


@pytest.fixture(scope="module")
def code(repository: Path) -> str:
    """The block of the page that defines the function."""
    text = (repository / "docs" / "format.md").read_text("utf-8")
    section = text.split("## Writing a solid body")[1].split("\n## ")[0]
    lines = section.splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("    import"))
    last = max(i for i, line in enumerate(lines) if line.startswith("    "))
    return "\n".join(line[4:] for line in lines[first : last + 1])


@pytest.fixture(scope="module")
def written(code: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clamped bar of trilinear bricks, six modes by dense algebra."""
    body = bar()
    n = len(body.nodes)
    held = np.flatnonzero(body.nodes[:, 0] < 1e-9)
    free = np.setdiff1d(np.arange(3 * n), 3 * held[:, None] + np.arange(3))
    K, M = (A.toarray()[np.ix_(free, free)] for A in (body.K, body.M))
    vectors = scipy.linalg.eigh(K, M, subset_by_index=[0, 5])[1]
    X = np.zeros((6, 3 * n))
    X[:, free] = vectors.T
    stiffness = vectors.T @ K @ vectors
    stiffness = (stiffness + stiffness.T) / 2.0
    file = tmp_path_factory.mktemp("strangers") / "solid.vtkhdf"
    ends = {"root": held, "tip": np.flatnonzero(body.nodes[:, 0] > SIZE[0] - 1e-9)}
    names: dict[str, Any] = {}
    exec(code, names)
    w, Ms = np.sqrt(np.diag(stiffness)), body.M[::3, ::3].toarray()
    shapes = X.reshape(6, n, 3)
    names["write_solid"](str(file), body.nodes, body.cells, 12, Ms, shapes, w, stiffness, ends)
    return file


def test_it_is_short_and_needs_h5py_only(code: str) -> None:
    assert len(code.splitlines()) < 40
    assert re.findall("import.*", code) == ["import os, h5py, numpy as np"]


def test_the_file_is_valid(written: Path) -> None:
    """Missing attributes of 28 datasets are one finding, and no error hides behind them."""
    findings = validate(written)
    assert not [f for f in findings if f.level == "error"]
    attributes = [f for f in findings if "attribute unit, frame, description" in f.message]
    assert len(attributes) == 1
    assert re.search(r"missing here and in \d\d other datasets", attributes[0].message)
    assert len(findings) < 5
    package = read_package(written)
    assert package.n_mode == 6
    trace = np.einsum("aaij->ij", package.invariants.T11_B)
    np.testing.assert_allclose(trace, package.mass, atol=1e-12)


def rename(file: h5py.File) -> None:
    file.move("modal_package/modes/kinds", "modal_package/modes/kind")


def one_based(file: h5py.File) -> None:
    file["modal_package/mesh/connectivity"][()] += 1


def millimetres(file: h5py.File) -> None:
    file["modal_package/modes/shapes_B"][()] *= 1e3


def row_sums(file: h5py.File) -> None:
    file["modal_package/invariants/T11_B"][()] *= 1.125


def turned(file: h5py.File) -> None:
    value = file["modal_package/interfaces/tip/psi_B"][()].T
    del file["modal_package/interfaces/tip/psi_B"]
    file["modal_package/interfaces/tip/psi_B"] = value


@pytest.mark.parametrize(
    ("slip", "message"),
    [
        (rename, "modes/kinds"),
        (one_based, "connectivity"),
        (millimetres, "phi_B.*differs"),
        (row_sums, "T11_B.*exceeds the modal mass by 12.5 % in mode . and by"),
        (turned, "psi_B"),
    ],
)
def test_slips_are_named(written: Path, tmp_path: Path, slip: Any, message: str) -> None:
    file = tmp_path / "slip.vtkhdf"
    file.write_bytes(written.read_bytes())
    with h5py.File(file, "r+") as h5:
        slip(h5)
    errors = [f"{f.dataset} {f.message}" for f in validate(file) if f.level == "error"]
    assert any(re.search(message, error) for error in errors), errors
