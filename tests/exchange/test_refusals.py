"""Matrices and import files that are refused, each with a message that says what to do."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sp
from samples.brick_model import Brick
from samples.exchange_samples import TOTAL, bar, request, write_matrices

from plymotion.preprocess.exchange import from_matrices
from plymotion.preprocess.exchange.__main__ import main
from plymotion.solver.errors import InputError


@pytest.fixture(scope="module")
def body() -> Brick:
    return bar()


def held(body: Brick) -> dict[str, Any]:
    """A spring to the ground at one node."""
    K = sp.lil_matrix(body.K)
    K[0, 0] += 1e6
    return {"K": K.tocsr()}


def without_rows(body: Brick) -> dict[str, Any]:
    """Supports taken out: the dofs of the first node along x and y are missing."""
    keep = np.setdiff1d(np.arange(3 * len(body.nodes)), [0, 1])
    matrices = {name: getattr(body, name)[keep][:, keep] for name in ("K", "M")}
    return {**matrices, "dofs": [body.dofs[i] for i in keep]}


def two_parts(body: Brick) -> dict[str, Any]:
    """The same body twice, beside itself."""
    n = len(body.nodes)
    return {
        "K": sp.block_diag([body.K, body.K]).tocsr(),
        "M": sp.block_diag([body.M, body.M]).tocsr(),
        "nodes": np.vstack([body.nodes, body.nodes + np.array([0.0, 0.1, 0.0])]),
        "dofs": [*body.dofs, *((node + n, k) for node, k in body.dofs)],
    }


def hinge(body: Brick) -> dict[str, Any]:
    """A pendulum of one more node with mass: it hangs on a bar, and moves across it."""
    n = len(body.nodes)
    d = np.array([0.1, 0.0, 0.0])
    bar = 1e6 * np.kron([[1.0, -1.0], [-1.0, 1.0]], np.outer(d, d) / (d @ d))
    K = sp.block_diag([body.K, sp.csr_matrix((3, 3))]).tolil()
    last = 3 * (n - 1) + np.arange(6)
    K[np.ix_(last, last)] += bar
    M = sp.block_diag([body.M, 0.01 * sp.eye(3)]).tocsr()
    dofs = [*body.dofs, *((n + 1, k) for k in (1, 2, 3))]
    return {
        "K": K.tocsr(),
        "M": M,
        "nodes": np.vstack([body.nodes, body.nodes[-1] + d]),
        "dofs": dofs,
    }


def swapped(body: Brick) -> dict[str, Any]:
    """Coordinates in another order than the matrices."""
    order = np.arange(len(body.nodes))
    order[[30, 150]] = order[[150, 30]]
    return {"nodes": body.nodes[order]}


REFUSED: list[tuple[str, Callable[[Brick], dict[str, Any]], str]] = [
    ("mass", lambda b: {"total_mass": 1.1 * TOTAL}, r"total_mass = 0.594 kg, but .* 0.54 kg"),
    ("held", held, r"a force opposes translation x .*the body is held: remove supports"),
    ("constrained", without_rows, r"node 1 has no degree of freedom along x, y .*held mass is lo"),
    ("parts", two_parts, r"2 unconnected parts with 12 rigid motions, with the nodes 1, 253"),
    ("hinge", hinge, r"expected six motions without stiffness, found 8: .*node 253, direction"),
    ("order", swapped, r"opposes rotation .*coordinates do not belong to the matrices"),
    (
        "label",
        lambda b: {"dofs": [*b.dofs[:-1], b.dofs[0]]},
        r"repeat .* first node 1, direction x",
    ),
    ("triangle K", lambda b: {"K": sp.triu(b.K).tocsr()}, "stiffness: holds its upper triangle"),
    ("triangle M", lambda b: {"M": sp.tril(b.M).tocsr()}, "mass: holds its lower triangle"),
    ("size", lambda b: {"K": b.K[:9, :9]}, r"stiffness: expected 756 x 756 .* found 9 x 9"),
    ("nan", lambda b: {"M": b.M * np.nan}, "mass: expected finite numbers"),
    ("zero", lambda b: {"M": b.M * 0.0}, "mass: all entries are zero"),
    ("label of dof", lambda b: {"dofs": [*b.dofs[:-1], (999, 1)]}, "no node has the label 999"),
    ("direction", lambda b: {"dofs": [*b.dofs[:-1], (1, 7)]}, "direction 7, expected 1 to 6"),
    ("units", lambda b: {"units": {"length": "mm", "mass": "t", "time": "s"}}, "check `units`"),
    ("many", lambda b: {"modes": [{"kind": "lowest", "count": 900}]}, "900 vibrations of a body"),
    ("at", lambda b: {"reference": {"kind": "clamped", "at": "rot"}}, "did you mean 'root'"),
    ("direction of load", lambda b: {"modes": [{"kind": "lowst", "count": 1}]}, "mean 'lowest'"),
]


@pytest.mark.parametrize(
    ("change", "message"), [r[1:] for r in REFUSED], ids=[r[0] for r in REFUSED]
)
def test_matrices_are_refused(
    body: Brick, change: Callable[[Brick], dict[str, Any]], message: str
) -> None:
    boxes = {
        "root": {"nodes": [1, 2, 3, 4, 5, 6], "link": "rigid"},
        "tip": {"nodes": [241, 242, 245, 248], "link": "rigid"},
    }
    arguments = {"K": body.K, "M": body.M, "nodes": body.nodes, "dofs": body.dofs}
    arguments |= request(interfaces=boxes) | change(body)
    M, K = arguments.pop("M"), arguments.pop("K")
    nodes, dofs = arguments.pop("nodes"), arguments.pop("dofs")
    with pytest.raises(InputError, match=message):
        from_matrices(M, K, nodes, dofs, **arguments)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"nodes": [1], "link": "rigid"}, "root: one node without usable rotations"),
        ({"nodes": [1, 13, 25], "link": "rigid"}, "root: 3 nodes on one line without usable"),
        ({"nodes": [1, 2, 5]}, "interfaces.root.link: missing"),
        ({"nodes": [1, 2, 5], "link": "average"}, 'expected "rigid": it carries the body frame'),
        ({"nodes": [1, 2, 999], "link": "rigid"}, "no node has the label 999"),
        ({"set": "NROOT", "link": "rigid"}, "no such set of nodes"),
        ({"box": [[5, 5, 5], [6, 6, 6]], "link": "rigid"}, "none of its nodes"),
        ({"nodes": [1, 2, 5], "box": [], "link": "rigid"}, "expected one of set, nodes, box"),
        ({"nodes": [1, 2, 5], "link": "rigid", "weights": "area"}, "no face of a cell lies on"),
        ({"nodes": [252, 251, 250, 247], "link": "rigid"}, "both rigid, and both have node"),
    ],
)
def test_interfaces_are_refused(body: Brick, table: dict[str, Any], message: str) -> None:
    tables = request()["interfaces"] | {"root": table}
    with pytest.raises(InputError, match=message):
        from_matrices(body.M, body.K, body.nodes, body.dofs, **request(interfaces=tables))


EDITS = [
    ('from = "matrices"', 'from = "matrixes"', "expected one of .*did you mean 'matrices'"),
    ("total_mass", "totl_mass", "arm.toml: totl_mass: unknown key; did you mean 'total_mass'"),
    ('"K.mtx"', '"L.mtx"', "arm.toml: files.stiffness = 'L.mtx': no such file"),
    ('cells = "cells.csv"', 'cell = "cells.csv"', "files.cell: unknown key; did you mean 'cells'"),
    ('units = { length = "m"', 'units = { length = "metre"', "units.length: expected one of m, cm"),
    ('kind = "lowest"', "kind = {}", "arm.toml: modes.*kind.*: expected one of .*, found {}"),
    ("format = 1", "format = [", "arm.toml: "),
]


@pytest.mark.parametrize(("old", "new", "message"), EDITS)
def test_import_files_are_refused(
    body: Brick,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    old: str,
    new: str,
    message: str,
) -> None:
    file = write_matrices(tmp_path, body)
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    out = tmp_path / "arm.vtkhdf"
    assert main(["import", str(file), "-o", str(out), "--quiet"]) == 2
    error = capsys.readouterr().err
    assert re.search(message, error), error
    assert not out.exists()
    assert not list(tmp_path.glob("*.vtkhdf*"))


def test_a_triangle_that_is_not_declared_is_refused(
    body: Brick, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_matrices(tmp_path, body)
    scipy.io.mmwrite(tmp_path / "M.mtx", sp.tril(body.M), symmetry="general")
    assert main(["import", str(file), "-o", str(tmp_path / "arm.vtkhdf"), "--quiet"]) == 2
    assert "mass: holds its lower triangle only" in capsys.readouterr().err
    scipy.io.mmwrite(tmp_path / "M.mtx", body.M, symmetry="general")
    text = (tmp_path / "M.mtx").read_text().replace("general", "symmetric", 1)
    (tmp_path / "M.mtx").write_text(text)
    assert main(["import", str(file), "-o", str(tmp_path / "arm.vtkhdf"), "--quiet"]) == 2
    assert "M.mtx: symmetric: expected one triangle" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "line", "message"),
    [
        ("nodes.csv", "253,0.1,0.2", r"nodes.csv:254: expected node, x, y, z"),
        ("dofs.csv", "1,xy", r"dofs.csv:758: expected node, direction"),
        ("cells.csv", "12,1,2,3000", r"cells.csv:122: no node has the label 3000"),
        ("K.mtx", "1 1", r"K.mtx:\d+: expected 3 numbers, found"),
    ],
)
def test_a_wrong_line_is_named(
    body: Brick,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    name: str,
    line: str,
    message: str,
) -> None:
    file = write_matrices(tmp_path, body)
    with (tmp_path / name).open("a") as stream:
        stream.write(f"{line}\n")
    assert main(["import", str(file), "-o", str(tmp_path / "arm.vtkhdf"), "--quiet"]) == 2
    assert re.search(message, capsys.readouterr().err)


def test_a_body_is_left_as_it_is(body: Brick) -> None:
    """Nothing of the caller's is changed."""
    before = replace(body, nodes=body.nodes.copy(), K=body.K.copy(), M=body.M.copy())
    from_matrices(body.M, body.K, body.nodes, body.dofs, **request())
    assert (before.K != body.K).nnz == 0
    assert (before.M != body.M).nnz == 0
    np.testing.assert_array_equal(before.nodes, body.nodes)
