"""MBDyn's .fem and SID, read back by readers of their own, against sums over the nodes."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import scipy.sparse as sp
from samples.exchange_samples import bar, exported, request

from plymotion.preprocess.exchange import from_matrices
from plymotion.solver.math.arrays import Array
from plymotion.solver.package import ModalPackage, read_package, write_package


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The arm with point masses: every integral is a sum over its nodes."""
    body = bar()
    M = sp.csr_matrix(sp.diags(np.asarray(body.M.sum(axis=1)).ravel()))
    tables = request()["interfaces"]
    tables["tip"]["rotation_deg"] = [10.0, 20.0, 30.0]
    package = from_matrices(
        M, body.K, body.nodes, body.dofs, damping_ratio=0.02, **request(interfaces=tables)
    )
    file = tmp_path_factory.mktemp("text") / "arm.vtkhdf"
    write_package(file, package)
    return file


@pytest.fixture(scope="module")
def package(file: Path) -> ModalPackage:
    return read_package(file)


def record_groups(file: Path) -> dict[int, list[list[str]]]:
    """Words of the lines of each record group, comments left out, as MBDyn's manual says."""
    groups: dict[int, list[list[str]]] = {}
    now: list[list[str]] = []
    for line in file.read_text().splitlines():
        found = re.match(r"\*\* RECORD GROUP (\d+),", line)
        if found:
            now = groups.setdefault(int(found[1]), [])
        elif not line.startswith("**"):
            now.append(line.split())
    return groups


def test_mbdyn_has_every_record_in_place(file: Path, package: ModalPackage, tmp_path: Path) -> None:
    out = exported(file, "mbdyn", tmp_path / "arm.fem")
    groups = record_groups(out)
    assert list(groups) == list(range(1, 13))
    n, m = len(package.nodes_B), package.n_mode
    assert groups[1] == [["REV0", str(n), str(m), "0", "0", "0"]]
    assert [int(row[0]) for row in groups[2]] == package.node_ids.tolist()
    numbers = {k: np.array(rows, dtype=float) for k, rows in groups.items() if 2 < k < 12}
    assert not numbers[3].any()
    assert not numbers[4].any()
    assert numbers[3].size == numbers[4].size == m
    points = np.column_stack([numbers[k] for k in (5, 6, 7)])
    np.testing.assert_array_equal(points, package.nodes_B)
    np.testing.assert_array_equal(numbers[8].reshape(m, n, 6), package.shapes_B)
    np.testing.assert_array_equal(numbers[9], package.mass)
    np.testing.assert_array_equal(numbers[10], package.stiffness)
    np.testing.assert_array_equal(numbers[11][:, :3], np.repeat(package.node_mass, 3).reshape(n, 3))
    # One line of comment before each mode, and its number.
    heads = re.findall(r"^\*\* +NORMAL MODE SHAPE # +(\d+)$", out.read_text(), re.MULTILINE)
    assert heads == [str(i) for i in range(1, m + 1)]


def test_mbdyn_has_the_inertia_about_the_mass_centre(
    file: Path, package: ModalPackage, tmp_path: Path
) -> None:
    rows = record_groups(exported(file, "mbdyn", tmp_path / "arm.fem"))[12]
    assert [len(row) for row in rows] == [1, 3, 3, 3, 3]
    w, x = package.node_mass, package.nodes_B
    centre = w @ x / w.sum()
    r = x - centre
    J = np.einsum("n,nc,nc->", w, r, r) * np.eye(3) - np.einsum("n,na,nb->ab", w, r, r)
    assert float(rows[0][0]) == pytest.approx(w.sum(), rel=1e-12)
    np.testing.assert_allclose(np.array(rows[1], dtype=float), centre, atol=1e-12)
    np.testing.assert_allclose(np.array(rows[2:], dtype=float), J, atol=1e-12 * J.max())


class Series(NamedTuple):
    """One Taylor series: m0 (rows, columns), m1 (rows, modes, columns)."""

    m0: Array
    m1: Array

    def at(self, q: Array) -> Array:
        """Value of the series."""
        return np.asarray(self.m0 + np.einsum("rqc,q->rc", self.m1, q))


def read_sid(file: Path) -> dict[str, Series]:
    """The series of a SID by name; those of nodes as "node 1 phi"."""
    found: dict[str, Series] = {}
    keys: dict[str, int] = {}
    node, name = "", ""
    entries: list[tuple[str, float]] = []
    for line in file.read_text().splitlines():
        key, _, value = (part.strip() for part in line.partition("="))
        if key == "new node":
            node = f"node {int(value)} "
        elif key == "end node":
            node = ""
        elif key in {"order", "nrow", "ncol", "nq", "nqn", "structure"}:
            keys[key] = int(value)
        elif key.startswith(("m0", "m1")):
            entries.append((key, float(value.replace("D", "E"))))
        elif name and key == f"end {name}":
            m0 = np.zeros((keys["nrow"], keys["ncol"]))
            m1 = np.zeros((keys["nrow"], keys["nq"], keys["ncol"]))
            for place, number in entries:
                at = tuple(int(k) - 1 for k in re.findall(r"\d+", place)[1:])
                (m0 if place.startswith("m0") else m1)[at] = number
            assert keys["order"] == int(m1.any() or keys["order"])
            found[node + name] = Series(m0, m1)
        elif not key.startswith("end"):
            name, keys, entries = key, {}, []
    return found


@pytest.fixture(scope="module")
def sid(file: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Series]:
    return read_sid(exported(file, "sid", tmp_path_factory.mktemp("sid") / "arm.SID_FEM"))


def test_sid_has_the_order_of_its_kind(file: Path, sid: dict[str, Series], tmp_path: Path) -> None:
    expected = ["mdCM", "J", "Ct", "Cr", "Me", "Gr", "Ge", "Oe", "ksigma", "Ke", "De"]
    assert [name for name in sid if not name.startswith("node")] == expected
    assert [name for name in sid if name.startswith("node 2")] == [
        f"node 2 {part}" for part in ("origin", "phi", "psi", "AP")
    ]
    text = exported(file, "sid", tmp_path / "arm.SID_FEM").read_text()
    assert re.match(r" +2 +12 +:No\. nodes, No\. modes", text)
    assert text.split().count("part") == 2


def test_sid_integrals_are_sums_over_the_nodes(
    package: ModalPackage, sid: dict[str, Series]
) -> None:
    """Momentum, angular momentum and forces of inertia of point masses, at a state with speed.

    The series are those of first order in q, so q is taken small and its square left out.
    """
    rng = np.random.default_rng(5)
    w, x = package.node_mass, package.nodes_B
    phi = np.moveaxis(package.shapes_B[:, :, :3], 0, 2)  # (n, 3, m)
    m = package.n_mode
    size = 1e-7 / np.abs(phi).max(axis=(0, 1))  # q moves nodes by 1e-7 m
    q, speed, omega = rng.normal(size=m) * size, rng.normal(size=m), rng.normal(size=3)
    u, v = phi @ q, phi @ speed
    r = x + u

    def close(found: Array, exact: Array) -> None:
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-8 * np.abs(exact).max())

    close(sid["mdCM"].at(q)[:, 0], w @ r)
    J = np.einsum("n,nc,nc->", w, r, r) * np.eye(3) - np.einsum("n,na,nb->ab", w, r, r)
    close(sid["J"].at(q)[:, 0], J[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])
    close(sid["Ct"].at(q), np.einsum("n,nai->ia", w, phi))
    close(sid["Cr"].at(q), np.einsum("n,nia->ia", w, np.cross(r[:, None], np.moveaxis(phi, 2, 1))))
    close(sid["Me"].at(q), np.einsum("n,nai,naj->ij", w, phi, phi))
    # Coriolis: moment of the frame at rest shape, and force of the modes.
    coriolis = 2.0 * np.cross(omega, v)
    Gr = np.einsum("aib,i->ab", sid["Gr"].m0.reshape(3, m, 3), speed)
    close(Gr @ omega, np.einsum("n,na->a", w, np.cross(x, coriolis)))
    Ge = np.einsum("lib,i->lb", sid["Ge"].m0.reshape(m, m, 3), speed)
    close(Ge @ omega, np.einsum("n,nal,na->l", w, phi, coriolis))
    # Centrifugal force of the modes.
    a, b, c = omega
    products = np.array([a * a, b * b, c * c, a * b, b * c, a * c])
    away = np.cross(omega, np.cross(omega, r))
    close(sid["Oe"].at(q) @ products, np.einsum("n,nal,na->l", w, phi, away))
    close(sid["Ke"].m0, package.stiffness)
    close(sid["De"].m0, package.damping)


def test_sid_series_have_their_terms_of_first_order(
    package: ModalPackage, sid: dict[str, Series]
) -> None:
    """Differences with a q so large that the constant terms do not hide them."""
    w, x = package.node_mass, package.nodes_B
    phi = np.moveaxis(package.shapes_B[:, :, :3], 0, 2)
    across = np.einsum(
        "n,nlka->lka",
        w,
        np.cross(np.moveaxis(phi, 2, 1)[:, None], np.moveaxis(phi, 2, 1)[:, :, None]),
    )
    np.testing.assert_allclose(sid["Cr"].m1, across, atol=1e-10 * np.abs(across).max())
    T = np.einsum("n,na,nbi->abi", w, x, phi)
    J1 = 2.0 * np.einsum("aai->i", T) * np.eye(3)[:, :, None] - T - np.moveaxis(T, 0, 1)
    rows = J1[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    np.testing.assert_allclose(sid["J"].m1[:, :, 0], rows, atol=1e-10 * np.abs(rows).max())
    e = np.eye(3)
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]
    for k, (i, j) in enumerate(pairs):
        both = {(i, j), (j, i)}
        force = sum(
            np.cross(e[s], np.cross(e[t][None], np.moveaxis(phi, 2, 1))) for s, t in both
        )  # (n, m, 3)
        exact = np.einsum("n,nal,nka->lk", w, phi, force)
        np.testing.assert_allclose(
            sid["Oe"].m1[:, :, k], exact, atol=1e-10 * max(np.abs(exact).max(), 1.0)
        )


def test_sid_nodes_are_the_interfaces(package: ModalPackage, sid: dict[str, Series]) -> None:
    tip = package.interfaces[1]
    np.testing.assert_allclose(sid["node 2 origin"].m0[:, 0], tip.position_B, atol=1e-11)
    np.testing.assert_allclose(sid["node 2 phi"].m0, tip.phi_B, rtol=1e-11)
    np.testing.assert_allclose(sid["node 2 origin"].m1[:, :, 0], tip.phi_B, rtol=1e-11)
    np.testing.assert_allclose(sid["node 2 psi"].m0, tip.psi_B, rtol=1e-11)
    small = 1e-6 * np.arange(package.n_mode) / np.abs(tip.psi_B).max()
    turn = tip.psi_B @ small
    A = sid["node 2 AP"].at(small)
    expected = tip.A_BI + np.cross(turn[None], tip.A_BI.T).T
    np.testing.assert_allclose(A, expected, atol=1e-11)
    assert np.abs(A.T @ A - np.eye(3)).max() < 1e-8
