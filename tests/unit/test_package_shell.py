"""Laminates and resultants of a shell in the modal package: round trip, validation, damage."""

import dataclasses
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from peers.ply_stresses import body_strength, shell_ply_stress, shell_resultants
from samples.package_samples import same
from samples.panel_sample import THICKNESS, WIDTH, E, panel, with_face_stresses
from samples.recovery_samples import STEEL_STRENGTH

from plymotion.solver.errors import PackageError
from plymotion.solver.package import read_package, validate, write_package
from plymotion.solver.package.body.package_schema import CellResultants, LaminateData
from plymotion.solver.strength.strength_summary import failure_text, summary


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("written") / "panel.vtkhdf"
    write_package(path, panel())
    return path


def test_a_shell_is_sound_and_reads_back(file: Path) -> None:
    assert validate(file) == []
    assert same(panel(), read_package(file))


def test_an_older_reader_finds_a_body_without_stresses(file: Path) -> None:
    """The new groups may be skipped: nothing else depends on them."""
    with h5py.File(file, "a") as h5:
        for name in ("laminates", "cell_resultants"):
            del h5[f"modal_package/{name}"]
        del h5.attrs["content_sha256"]
    found = read_package(file)
    assert (found.laminates, found.cell_resultants) == ((), None)
    assert body_strength(found, np.zeros(2), np.zeros((2, 3))) is None


def _cells(**changes: Any) -> CellResultants:
    found = panel().cell_resultants
    assert found is not None
    return dataclasses.replace(found, **changes)


def _laminate(**changes: Any) -> LaminateData:
    return dataclasses.replace(panel().laminates[0], **changes)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"cell_resultants": _cells(cell=np.arange(1, 33))}, "cell_resultants/cell"),
        ({"cell_resultants": _cells(laminate=np.ones(32, int))}, "cell_resultants/laminate"),
        ({"cell_resultants": _cells(A_BE=np.ones((32, 3, 3)))}, "cell_resultants/A_BE"),
        (
            {"cell_resultants": _cells(resultants_E=np.full((32, 8, 3), np.nan))},
            "cell_resultants/resultants_E",
        ),
        ({"cell_resultants": _cells(resultants_E=np.ones((32, 6, 3)))}, "resultants_E"),
        ({"laminates": (_laminate(ABD=np.zeros((6, 6))),)}, "laminates/wall/ABD"),
        ({"laminates": (_laminate(materials={"stele": {}}),)}, "laminates/wall/plies/material"),
        ({"laminates": (_laminate(name="a/b"),)}, "a/b"),
    ],
)
def test_what_cannot_be_used_is_not_written(
    tmp_path: Path, changes: dict[str, Any], named: str
) -> None:
    with pytest.raises(PackageError, match=named):
        write_package(tmp_path / "bad.vtkhdf", dataclasses.replace(panel(), **changes))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("changes", "named", "words"),
    [
        (
            {"laminates": (_laminate(stress_M=0.9 * panel().laminates[0].stress_M),)},
            "laminates/wall/plies/stress_M",
            "integrate to 0.9",
        ),
        (
            {"cell_resultants": _cells(resultants_E=1e3 * _cells().resultants_E)},
            "cell_resultants/resultants_E",
            "strain energy",
        ),
        (
            {"cell_resultants": _cells(A_BE=np.tile(np.eye(3)[[1, 2, 0]], (32, 1, 1)))},
            "cell_resultants/A_BE",
            "not normal to the cell",
        ),
    ],
)
def test_what_does_not_belong_to_the_body_is_a_warning(
    tmp_path: Path, changes: dict[str, Any], named: str, words: str
) -> None:
    write_package(tmp_path / "odd.vtkhdf", dataclasses.replace(panel(), **changes))
    (found,) = validate(tmp_path / "odd.vtkhdf")
    assert (found.level, found.dataset) == ("warning", f"/modal_package/{named}")
    assert words in found.message


@pytest.mark.parametrize("part", ["cell_resultants/laminate", "laminates/wall/ABD"])
def test_a_missing_part_is_named(file: Path, part: str) -> None:
    with h5py.File(file, "a") as h5:
        del h5[f"modal_package/{part}"]
    with pytest.raises(PackageError, match=part):
        read_package(file)


def test_stresses_of_a_bent_strip_are_those_of_beam_theory() -> None:
    """M11 = -D w'' per width: s11 = E z k at the faces, in the cell next to the root."""
    package, q = panel(), np.array([[0.0, 0.0, 0.0], [0.02, -0.01, 0.003]])
    assert package.cell_resultants is not None
    F = shell_resultants(package, 0, q)
    stress = shell_ply_stress(package, 0, q)
    curvature = F[3] / (E * THICKNESS**3 / 12.0)
    expected = np.outer(curvature, 0.5 * THICKNESS * E * np.array([-1.0, 0.0, 1.0]))
    np.testing.assert_allclose(stress[:, 0, :, 0], expected, atol=1e-6 * abs(expected).max())


def test_strength_is_the_worst_of_all_cells_plies_and_instants() -> None:
    package = panel()
    t = np.linspace(0.0, 1.0, 60)
    q = 0.02 * np.sin(np.outer(t, [7.0, 31.0, 45.0]) + np.array([0.1, 0.7, 2.0]))
    found = body_strength(package, t, q)
    assert found is not None
    assert package.cell_resultants is not None
    rows = range(len(package.cell_resultants.cell))
    every = np.array([shell_ply_stress(package, row, q)[:, 0, :, 0] for row in rows])
    worst = np.abs(every).max()  # of one stress alone, von Mises is its magnitude
    governing = found.governing
    assert governing.ratio == pytest.approx(STEEL_STRENGTH["yield_stress"] / worst, rel=1e-12)
    row, instant, _ = np.unravel_index(np.argmax(np.abs(every)), every.shape)
    assert governing.time == t[instant]
    centre = package.nodes_B[package.connectivity.reshape(-1, 3)[row]].mean(axis=0)
    np.testing.assert_allclose(governing.point, centre)
    assert max(found.exposure["von-mises"]) == pytest.approx(1.0 / governing.ratio)
    table = summary(found)
    assert table["ply"] == {"region": "wall", "index": 0, "material": "steel", "angle_deg": 0.0}
    assert len(table["along_beam"]["x"]) == len(found.station_x) <= 32
    text = failure_text("panel", governing)
    assert "at its bottom" in text or "at its top" in text
    assert 0.0 < centre[1] < WIDTH


def test_faces_of_a_solid_are_judged_by_their_stresses() -> None:
    package = with_face_stresses()
    t = np.linspace(0.0, 1.0, 60)
    q = 0.02 * np.sin(np.outer(t, [7.0, 31.0, 45.0]) + np.array([0.1, 0.7, 2.0]))
    found = body_strength(package, t, q)
    assert found is not None
    assert package.face_stresses is not None
    worst = np.abs(np.einsum("fm,tm->ft", package.face_stresses.stress_M[:, 0], q)).max()
    expected = STEEL_STRENGTH["yield_stress"] / worst
    assert found.governing.ratio == pytest.approx(expected, rel=1e-12)
    assert found.governing.ply.region == "surface steel"
    assert "at its" not in failure_text("part", found.governing)
