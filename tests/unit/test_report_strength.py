"""Strength of plies from the run to summary, warnings and report."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.beam_samples import straight_line
from samples.recovery_samples import (
    PLY,
    PLY_CRITERIA,
    PLY_STRENGTH,
    mode_resultants,
    plies_of,
    rectangle_recovery,
)

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.package import ModalPackage
from plymotion.solver.report.bodies import strength_section
from plymotion.solver.report.case_figures import draw_exposure
from plymotion.solver.report.report_data import read_story
from plymotion.solver.report.report_page import make_report
from plymotion.solver.report.style import house_style
from plymotion.solver.results import write_result, write_summary
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.run.inputs import RunSpec

pytest.importorskip("matplotlib")

RUN = "layup-2"


def with_stresses(package: ModalPackage, scale: float | None) -> ModalPackage:
    """A beam with the recovery of a bar of 30 deg plies; strengths times `scale`, or none."""
    (section,) = package.sections
    materials: dict[str, dict[str, Any]] = {"cfrp": dict(PLY)}
    if scale is not None:
        strength = {key: scale * value for key, value in PLY_STRENGTH.items()}
        materials["cfrp"]["strength"] = strength
    plies = plies_of(*[("cfrp", 30.0)] * 3)
    recovery = rectangle_recovery(0.04, 0.01, plies, materials, columns=4)
    line = straight_line(package.nodes_B[:, 0], section.K, section.M, np.eye(3))
    columns = np.moveaxis(package.shapes_B, 0, 2).reshape(6 * line.n_node, -1)
    values = np.diag(package.stiffness)
    form = package.invariants.mass_form
    return dataclasses.replace(
        package,
        sections=(dataclasses.replace(section, recovery=recovery),),
        recovery=mode_resultants(line, columns, values, form, (0,)),
    )


@pytest.fixture(scope="module")
def spec(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> RunSpec:
    """A short run of the shipped double pendulum, its hand with strengths."""
    folder = tmp_path_factory.mktemp("case")
    case = load_case(repository / "cases/double-pendulum/case.toml", sweeps=())
    write_case(case, folder, repository / "tests/packages/double-pendulum")
    file = folder / f"runs/{RUN}.json"
    table = json.loads(file.read_text())
    table["mechanism"]["solver"]["t_end"] = 0.05
    for package in table["packages"].values():
        package["inputs_sha256"] = None  # any bending modes do
    file.write_text(json.dumps(table))
    read = read_run(file)
    arm = dataclasses.replace(read.packages["arm"], recovery=None)
    return dataclasses.replace(read, packages={**read.packages, "arm": arm})


def run(spec: RunSpec, scale: float | None, folder: Path) -> dict[str, Any]:
    packages = {**spec.packages, "hand": with_stresses(spec.packages["hand"], scale)}
    result, summary = execute(dataclasses.replace(spec, packages=packages), progress=False)
    folder.mkdir(parents=True)
    write_result(folder / "result.vtkhdf", result)
    write_summary(folder / "summary.json", summary)
    return dict(json.loads((folder / "summary.json").read_text()))


@pytest.fixture(scope="module")
def case_dir(spec: RunSpec, tmp_path_factory: pytest.TempPathFactory) -> Path:
    build = tmp_path_factory.mktemp("build")
    run(spec, 1.0, build / RUN)
    make_report(build, [RUN], {"title": "pendulum"}, figures=True)
    return build


def test_summary_names_ratio_place_and_time(case_dir: Path) -> None:
    summary = json.loads((case_dir / RUN / "summary.json").read_text())
    assert set(summary["strength"]) == {"hand"}
    found = summary["strength"]["hand"]
    assert found["ratio"] > 0.0
    assert found["margin"] == pytest.approx(found["ratio"] - 1.0)
    assert set(found["criteria"]) == PLY_CRITERIA
    lowest = min(found["criteria"].values(), key=lambda each: each["ratio"])
    assert (found["criterion"], found["ratio"]) == (lowest["criterion"], lowest["ratio"])
    along = found["along_beam"]
    assert found["x"] in along["x"]
    peaks = along["exposure"][found["criterion"]]
    assert max(peaks) == pytest.approx(1.0 / found["ratio"])
    assert along["x"][int(np.argmax(peaks))] == found["x"]
    assert found["ply"] == {
        "region": "plate",
        "index": found["ply"]["index"],
        "material": "cfrp",
        "angle_deg": 30.0,
    }
    assert set(found["stress"]) == {"unit", "11", "22", "33", "23", "13", "12"}
    assert 0.0 <= found["time"] <= 0.05
    ratios = [each["ratio"] for each in found["plies"]]
    assert ratios == sorted(ratios)
    assert ratios[0] == found["ratio"]
    assert sorted(each["ply"]["index"] for each in found["plies"]) == [0, 1, 2]


def test_strengths_scale_ratios_and_warn_below_one(
    spec: RunSpec, case_dir: Path, tmp_path: Path
) -> None:
    ratio = json.loads((case_dir / RUN / "summary.json").read_text())["strength"]["hand"]["ratio"]
    strong = run(spec, 1.1 / ratio, tmp_path / "strong" / RUN)
    assert strong["strength"]["hand"]["ratio"] == pytest.approx(1.1, rel=1e-6)
    assert "ply-failure" not in [w["code"] for w in strong["warnings"]]
    weak = run(spec, 0.8 / ratio, tmp_path / "weak" / RUN)
    assert weak["strength"]["hand"]["ratio"] == pytest.approx(0.8, rel=1e-6)
    (warning,) = [w for w in weak["warnings"] if w["code"] == "ply-failure"]
    assert warning["message"].startswith("hand: ")
    assert "strength ratio of 0.8 (expected above 1" in warning["message"]
    make_report(tmp_path / "weak", [RUN], {})
    assert "<span class='badge bad'>0.8</span>" in (tmp_path / "weak/report.html").read_text()


def test_report_has_table_and_figure(case_dir: Path) -> None:
    text = (case_dir / "report.html").read_text()
    assert ">Strength</h2>" in text
    ratio = json.loads((case_dir / RUN / "summary.json").read_text())["strength"]["hand"]["ratio"]
    assert f"<td data-v='{ratio!r}'>{ratio:.4g}</td>" in text
    assert "<h3>Weakest plies of each body</h3>" in text
    figure = case_dir / RUN / "strength.png"
    with house_style():
        again = draw_exposure(case_dir / "again.png", read_story(case_dir, RUN, RUN))
    assert again.read_bytes() == figure.read_bytes()


def test_a_solid_has_a_surface_in_place_of_plies(case_dir: Path) -> None:
    story = read_story(case_dir, RUN, RUN)
    story.summary["strength"]["hand"]["ply"] |= {"region": "surface steel", "material": "steel"}
    assert ">surface steel<" in strength_section([story])


def test_figure_shows_the_line_of_failure_where_it_is_near(case_dir: Path) -> None:
    from matplotlib.image import imread

    summary = json.loads((case_dir / RUN / "summary.json").read_text())
    red = {}
    for factor in (0.01, 0.9):
        along = summary["strength"]["hand"]["along_beam"]
        highest = max(map(max, along["exposure"].values()))
        along["exposure"] = {
            name: [factor / highest * value for value in values]
            for name, values in along["exposure"].items()
        }
        story = dataclasses.replace(read_story(case_dir, RUN, RUN), summary=summary)
        with house_style():
            figure = draw_exposure(case_dir / f"{factor}.png", story)
        pixels = np.round(imread(figure)[:, :, :3] * 255).astype(int)
        red[factor] = np.sum(np.all(pixels == (0xB0, 0x00, 0x20), axis=2))
        for shade in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)):
            assert np.sum(np.all(pixels == shade, axis=2)) > 50, shade
    assert red[0.01] == 0
    assert red[0.9] > 50


def test_nothing_is_said_where_nothing_has_strengths(spec: RunSpec, tmp_path: Path) -> None:
    assert run(spec, None, tmp_path / RUN)["strength"] == {}
    make_report(tmp_path, [RUN], {}, figures=True)
    assert ">Strength</h2>" not in (tmp_path / "report.html").read_text()
    assert not (tmp_path / RUN / "strength.png").exists()
