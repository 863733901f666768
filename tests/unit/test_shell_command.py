"""Output, figures and messages of the command `plymotion shell`, without FEniCSx."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from samples.recovery_samples import PLY_CRITERIA
from samples.shell_file_samples import STRENGTH, laminate_of, plate

from plymotion.preprocess.laminate.stiffness import Lamina, Laminate, laminate_stiffness
from plymotion.solver.__main__ import main
from plymotion.solver.package.shell.shell_file import read_shell, write_shell
from plymotion.solver.report.shell.findings import case_findings, shell_json, stacking
from plymotion.solver.report.shell.shell_figures import feature_edges, magnification, view_axes
from plymotion.solver.report.shell.shell_text import normal_lines, shell_text


def test_screen_names_what_matters() -> None:
    text = shell_text(plate())
    lines = text.splitlines()
    assert max(map(len, lines)) <= 100
    assert lines[0] == "plate: Half and half"
    for part in (
        "6 nodes, 4 triangles in left, right",
        "Normal e3       right: (0, 0, 1)",
        "4, bottom to top [0/90]s of cfrp",
        "symmetric, balanced",
        "at most 0.03 m, at (1, 0.5, 0) m",
        "Out of balance  0.0e+00 of the load",
        "tip uz = 0.025 m",
        "tip N11 = 30000 N/m",
        "1 without strain energy, 0 Hz",
        "7.95775",
        "36 unknowns, 0.25 s",
        "warning [sliver-cells] two of them",
    ):
        assert part in text, part


def test_normals_of_a_tube_in_words() -> None:
    angle = 2.0 * np.pi * np.arange(8) / 8.0
    ring = np.column_stack([0.0 * angle, np.cos(angle), np.sin(angle)])
    i = np.arange(8)
    j = (i + 1) % 8
    middle = angle + np.pi / 8.0
    e3 = np.column_stack([0.0 * angle, np.cos(middle), np.sin(middle)])
    e1 = np.tile([1.0, 0.0, 0.0], (8, 1))
    A_GE = np.stack([e1, np.cross(e3, e1), e3], axis=2)
    tube = dataclasses.replace(
        plate().mesh,
        nodes_G=np.concatenate([ring, ring + np.eye(3)[0]]),
        cells=np.column_stack([i, j, j + 8, i + 8]),
        region=np.zeros(8, dtype=int),
        regions=("wall",),
        A_GE=A_GE,
        area=np.ones(8),
    )
    for sign, words in ((1.0, "outwards"), (-1.0, "inwards")):
        turned = A_GE * [1.0, sign, sign]
        (line,) = normal_lines(dataclasses.replace(tube, A_GE=turned))
        assert line.startswith(f"Normal e3       wall: {words}")
    A_GE[:4, :, 1:] *= -1.0
    assert "varies" in normal_lines(tube)[0]


def test_large_rotations_are_told() -> None:
    shell = plate()
    assert "linear statics" not in shell_text(shell)
    shell.cases.displacements_G[0, 2, 3:] = 0.3, 0.0, 0.4
    assert "rotations up to 28.6 deg: this is linear statics" in shell_text(shell)


def test_long_names_stay_on_the_screen() -> None:
    shell = plate()
    name = "the-clamped-side-of-the-plate"
    shell = dataclasses.replace(shell, supports=dataclasses.replace(shell.supports, names=(name,)))
    lines = shell_text(shell).splitlines()
    assert f"Reaction {name}" in lines
    assert max(map(len, lines)) <= 100


def test_balance_takes_moments_to_the_origin() -> None:
    found, nothing = case_findings(plate())
    np.testing.assert_allclose(found.reactions_G, -found.load_G, atol=1e-12)
    assert found.imbalance < 1e-15
    assert nothing.imbalance == 0.0
    shell = plate()
    shell.cases.reactions_G[0, 0, 5] = 0.1  # N m that nothing asks for
    assert 1e-3 < case_findings(shell)[0].imbalance < 1e-2


def test_ply_stresses_are_those_of_the_ply() -> None:
    """Under N11 alone: strain from A^-1, stress in the 90 deg plies across their fibre."""
    shell = plate()
    (skin, metal), _ = (found.plies.values() for found in case_findings(shell))
    e = np.linalg.solve(shell.laminates[0].ABD[:3, :3], [2e5, 0.0, 0.0])
    from samples.laminate_samples import CFRP

    S = CFRP.compliance_M[np.ix_([0, 1], [0, 1])]
    along = np.linalg.solve(S, e[:2])
    across = np.linalg.solve(S, e[1::-1])
    np.testing.assert_allclose(skin[0].stress_M[:2], along, rtol=1e-9)
    np.testing.assert_allclose(skin[1].stress_M[:2], across, rtol=1e-9)
    assert list(skin[0].cells[:2]) == [1, 1]  # the cell of the higher force
    np.testing.assert_allclose(metal[0].stress_M[0], 3e4 / 2e-3, rtol=1e-9)
    ratios = {r.criterion: r.ratio for r in skin[1].reserves}
    assert set(ratios) == PLY_CRITERIA
    assert ratios["max-stress"] == pytest.approx(STRENGTH["Yt"] / across[1], rel=1e-9)
    assert metal[0].reserves == ()


def test_weakest_of_all_plies() -> None:
    found, nothing = case_findings(plate())
    assert found.weakest is not None
    laminate, ply, reserve = found.weakest
    every = [r.ratio for plies in found.plies.values() for p in plies for r in p.reserves]
    assert reserve.ratio == min(every)
    assert (laminate, ply.material) == ("skin", "cfrp")
    assert nothing.weakest is not None
    assert nothing.weakest[2].ratio == np.inf  # no stress


def test_json_holds_the_numbers() -> None:
    shell = plate()
    table = shell_json(shell)
    assert json.loads(json.dumps(table)) == table
    skin = table["laminates"]["skin"]
    np.testing.assert_array_equal(skin["A"], shell.laminates[0].ABD[:3, :3])
    np.testing.assert_array_equal(skin["D"], shell.laminates[0].ABD[3:, 3:])
    assert skin["stacking"] == "[0/90]s"
    case = table["cases"]["bending"]
    assert case["deflection"] == {"largest": 0.03, "node": 16, "at": [1.0, 0.5, 0.0]}
    assert case["probes"] == {"tip": {"uz": 0.025, "N11": 3e4}}
    assert case["reactions"]["root"][2] == -10.0
    assert table["frequencies_hz"] == pytest.approx([50 / (2 * np.pi), 120 / (2 * np.pi)])
    assert table["zero_modes"] == 1


def test_bound_in_words() -> None:
    found = {
        "of": "compliance", "case": "q", "unit": "J", "symmetric": True, "bound": 2.0,
        "value": 2.5, "gap": 0.25, "found": 2.1, "found_gap": 0.05,
        "found_gap_without_shear": 0.002, "found_angles_deg": [45.0, -45.0, -45.0, 45.0],
        "of_angles": {"allowed_deg": [0.0, 45.0, 90.0], "best": 2.2, "gap": 1e-5, "lay_ups": 9,
                      "angles_deg": [45.0, 0.0, 0.0, 45.0], "branches": 6, "computed": 2},
    }  # fmt: skip
    shell = plate()
    shell = dataclasses.replace(shell, provenance={**shell.provenance, "bound": found})
    lines = [line[16:] for line in shell_text(shell).splitlines()]
    at = lines.index("compliance under q: at least 2 J for any symmetric lay-up of these plies")
    assert lines[at + 1] == "this one 2.5 J, at most 25 % above any there is"
    rest = "best found 2.1 J, at most 5 % above (without transverse shear 0.2 %): [45/-45]s"
    assert lines[at + 2] == rest
    assert lines[at + 3] == "best of 0, 45, 90 deg 2.2 J, at most 0.001 % above: [45/0]s"
    assert lines[at + 4] == "6 branches, 2 of 9 lay-ups computed"
    assert shell_json(shell)["bound"] == found


@pytest.mark.parametrize(
    ("angles", "text"),
    [
        ((0, 90, 90, 0), "[0/90]s"),
        ((0, 30, 0, 30, 0, 30), "[0/30]3"),
        ((0, 90, 0), "[0/90/0]"),
        ((45, -45, 45, -45, -45, 45, -45, 45), "[45/-45]2s"),
        ((30,), "[30]"),
        ((0, 0), "[0]s"),
        ((45, 0, -45, 90), "[45/0/-45/90]"),
    ],
)
def test_stacking_in_words(angles: tuple[float, ...], text: str) -> None:
    from samples.laminate_samples import stack

    laminate = stack(*map(float, angles))
    assert stacking(laminate_of("x", laminate, ("cfrp",) * len(angles))) == text


def test_stacking_of_two_materials_is_no_mirror() -> None:
    from samples.laminate_samples import CFRP, GLASS

    laminate = Laminate((Lamina(CFRP, 0.0, 1e-3), Lamina(GLASS, 0.0, 1e-3)))
    shown = laminate_of("x", laminate, ("cfrp", "glass"))
    assert stacking(shown) == "[0]2"
    assert laminate_stiffness(laminate).B[0, 0] < 0.0


def test_command_shows_a_file_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    write_shell("plate.vtkhdf", plate())
    assert main(["shell", "plate.vtkhdf"]) == 0
    text = capsys.readouterr().out
    parts = ("bending", "nothing", "mode-1", "mode-2", "bending-buckling")
    figures = {f"plate-{name}.png" for name in parts}
    assert "Load factors    bending: 2.5, 7; load reversed -3" in text
    assert "Mesh error      +2, +4 %, estimated" in text
    assert "Mesh error      +25, -1 %, estimated" in text
    assert "factors without it 2, 7.0707" in text
    assert {file.name for file in tmp_path.glob("*.png")} == figures
    assert all(name in text for name in (*figures, "plate.vtkhdf (unchanged)"))
    before = {file: file.stat().st_mtime_ns for file in tmp_path.glob("*.png")}
    assert main(["shell", "plate.vtkhdf"]) == 0
    assert {file: file.stat().st_mtime_ns for file in before} == before
    capsys.readouterr()
    assert main(["shell", "plate.vtkhdf", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == shell_json(read_shell("plate.vtkhdf"))


def test_command_without_figures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_shell("plate.vtkhdf", dataclasses.replace(plate(), modes=None))
    assert main(["shell", "plate.vtkhdf", "--no-figures"]) == 0
    assert not list(tmp_path.glob("*.png"))
    assert "Frequencies" not in capsys.readouterr().out


def test_command_tells_what_is_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_text("format = 1\ntitle = 3\n")
    assert main(["shell", "a.toml", "none.toml", "--check"]) == 2
    seen = capsys.readouterr()
    assert "error: a.toml: title = 3: expected a text in quotes: one line" in seen.err
    assert "error: none.toml: no such shell description" in seen.err
    assert "0 of 2 descriptions are right" in seen.out
    (tmp_path / "sub").mkdir()
    assert main(["shell", "a.toml", "sub/a.toml", "--check"]) == 2
    assert "sub/a.toml: its files would overwrite those of a.toml" in capsys.readouterr().err
    (tmp_path / "bad.vtkhdf").write_text("nothing")
    assert main(["shell", "bad.vtkhdf"]) == 2
    assert "bad.vtkhdf" in capsys.readouterr().err


def test_edges_that_are_drawn() -> None:
    """The outline of a flat plate; not its diagonals. A fold as well."""
    shell = plate()
    edges = {tuple(edge) for edge in feature_edges(shell.mesh.nodes_G, shell.mesh.cells)}
    assert edges == {(0, 1), (1, 2), (2, 5), (4, 5), (3, 4), (0, 3)}
    folded = shell.mesh.nodes_G.copy()
    folded[[2, 5], 2] = 0.5
    edges = {tuple(edge) for edge in feature_edges(folded, shell.mesh.cells)}
    assert (1, 4) in edges


def test_scale_of_displacements_is_round() -> None:
    points = np.array([[0.0, 0, 0], [1.0, 0, 0]])
    for largest, factor in ((1e-3, 100.0), (0.12, 1.0), (5.9e-3, 20.0)):
        assert magnification(points, np.array([[0, 0, 0], [0, 0, largest]])) == factor
    assert magnification(points, np.zeros((2, 3))) == 0.0


def test_views_are_right_handed() -> None:
    axes = view_axes((1.0, -1.3, 0.9))
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert axes[1, 2] > 0.0  # z is up
