"""Strength in report.html: the exposure of the worst ply against NumPy."""

import dataclasses
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness.chromium import SOFTWARE, Browser
from samples.result_samples import swinging_rod

from plymotion.solver.__main__ import main
from plymotion.solver.package import read_package
from plymotion.solver.package.common.materials import PlyStrength, YieldStrength
from plymotion.solver.package.section.stress import strengths
from plymotion.solver.report.report_data import Story, comparisons
from plymotion.solver.report.report_page import make_report, page
from plymotion.solver.report.scene import site_exposure
from plymotion.solver.results import RunResult, Signal, read_result, write_result, write_summary
from plymotion.solver.results.run_result import BodyView, Sites, Surface
from plymotion.solver.strength import criteria_of
from plymotion.solver.strength.weakest_plies import resultants, unit_stress_M

pytest.importorskip("matplotlib")

RUN = "layup-2-four-modes"
PLY = PlyStrength(
    Xt=19.5, Xc=14.8, Yt=0.48, Yc=2.0, Zt=0.45, Zc=1.9, S12=0.79, S13=0.7, S23=0.3, F12_star=-0.4
)
METAL = YieldStrength(2.4)
TIMES = 400


@pytest.fixture(scope="module")
def case_dir(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped laminated box beam with strengths, a short run with its report."""
    folder = tmp_path_factory.mktemp("case")
    text = (repository / "cases/actuated-beam/case.toml").read_text()
    assert "t_end = 6.0" in text
    text = text.replace("t_end = 6.0", "t_end = 0.3").replace("../sections", "sections")
    (folder / "case.toml").write_text(text)
    shutil.copytree(repository / "cases/sections", folder / "sections")
    packages = repository / "tests/packages/actuated-beam"
    command = [str(folder / "case.toml"), "--run", RUN, "--packages", str(packages), "--quiet"]
    assert main([*command, "--out", str(folder / "build"), "--jobs", "1"]) == 0
    return folder / "build"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("browser") / "profile", *SOFTWARE) as opened:
        yield opened


def exposures(browser: Browser, body: int, times: list[float], solo: int = -1) -> np.ndarray:
    """Exposures (t, s) of the sites of a body of the first run; solo : number of a mode alone."""
    found = browser.run(f"""(() => {{
      const {{ page, bodyState, siteValues }} = plymotion, {{ scene }} = page.runs[0];
      const body = scene.bodies[{body}], state = (t) => bodyState(scene, body, t, {solo});
      const values = (t) => Array.from(siteValues(scene, body, state(t), 'exposure'));
      return {json.dumps(times)}.map(values);
    }})()""")
    return np.asarray(found)


def test_worst_ply_of_a_real_beam(browser: Browser, case_dir: Path, repository: Path) -> None:
    """Every point of the section and every criterion in NumPy; the page has governing points."""
    result = read_result(case_dir / RUN / "result.vtkhdf")
    number = next(i for i, body in enumerate(result.bodies) if body.name == "beam")
    view = result.bodies[number].view
    assert view is not None
    package = read_package(repository / f"tests/packages/actuated-beam/beam.{RUN}.vtkhdf")
    (section,) = package.sections
    assert section.recovery is not None
    assert view.sites is not None
    assert len(view.sites.stress_M) < len(section.recovery.points) / 10
    browser.open(case_dir / "report.html")
    assert browser.run("document.documentElement.dataset.renderer") == "webgl2"
    rows = list(range(20, len(result.t), 13))
    shown = exposures(browser, number, [float(result.t[row]) for row in rows])
    first, m = view.first_position + 7, len(view.shapes_B)
    F = resultants(package, result.q[rows, first : first + m])
    stress_M = unit_stress_M(section.recovery)
    (strength,) = strengths(section.recovery).values()
    largest = site_exposure(view.sites, result.q[:, first : first + m]).max()
    for k in range(len(rows)):
        stress = np.einsum("pij,sj->spi", stress_M, F[:, :, k])
        every = np.max([c.assess(stress, strength).exposure for c in criteria_of(strength)], axis=0)
        expected = every.max(axis=1)
        assert expected.max() > 0.01
        # Never above the exact value; the points were chosen from a sample of the times.
        exact = site_exposure(view.sites, result.q[rows[k : k + 1], first : first + m])[0]
        assert np.all(exact <= expected * (1 + 1e-9))
        np.testing.assert_allclose(exact, expected, rtol=5e-3, atol=1e-3 * expected.max())
        np.testing.assert_allclose(shown[k], exact, rtol=0, atol=1.001 * largest / 255 / 2)


def test_button_shows_the_worst_ply_at_its_time(browser: Browser, case_dir: Path) -> None:
    browser.open(case_dir / "report.html")
    summary = json.loads((case_dir / RUN / "summary.json").read_text())
    entry = summary["strength"]["beam"]
    browser.click("#worst")
    assert browser.run("plymotion.clock.t") == pytest.approx(entry["time"])
    caption = browser.run("document.getElementById('caption').textContent")
    assert f"R = {entry['ratio']:.4g}" in caption
    assert browser.run("document.getElementById('colour').value") == "exposure"
    drawn = "(plymotion.drawView(), document.getElementById('canvas').toDataURL())"
    coloured = browser.run(drawn)
    browser.run("document.getElementById('colour').value = 'body'")
    assert browser.run(drawn) != coloured
    browser.run("document.getElementById('colour').value = 'exposure'")
    result = read_result(case_dir / RUN / "result.vtkhdf")
    number = next(i for i, body in enumerate(result.bodies) if body.name == "beam")
    shown = exposures(browser, number, [entry["time"]])[0]
    assert shown.max() == pytest.approx(1.0 / entry["ratio"], rel=1e-3)
    x = np.array(entry["along_beam"]["x"])
    assert x[int(np.argmax(shown))] == pytest.approx(entry["x"])
    mark = browser.run("[plymotion.view.mark.body, plymotion.view.mark.node]")
    assert result.bodies[mark[0]].nodes_B[mark[1], 0] == pytest.approx(entry["x"], abs=1e-6)
    browser.run("plymotion.clock.set(0)")
    browser.click("#strength tbody tr:first-child button")
    assert browser.run("plymotion.clock.t") == pytest.approx(entry["time"])
    assert browser.errors() == []


def test_a_strength_ratio_has_gaps_and_a_logarithmic_scale(
    browser: Browser, tmp_path: Path
) -> None:
    """Infinite values and a run without stress; the path beside it on a narrow screen."""
    rod = swinging_rod(k=5)
    stories = []
    for run, values in (("soft", [np.inf, 20.0, 2000.0, np.inf, 30.0]), ("rigid", [np.inf] * 5)):
        ratio = Signal("R", "-", "ratio", np.array(values))
        result = dataclasses.replace(rod, run=run, signals=(*rod.signals[:2], ratio))
        inputs = {"signals": {"R": {"kind": "strength_ratio"}}}
        stories.append(Story(run, run, {"completed": True, "signals": {}}, result, inputs=inputs))
    runs = ["soft", "rigid"]
    figures = {
        "R": {"title": "R", "signal": "R", "runs": runs},
        "path": {"title": "path", "signal": "tip_y", "against": "tip_x", "runs": runs},
    }
    file = tmp_path / "report.html"
    file.write_text(page("ratio", stories, comparisons({"figures": figures}, stories)))
    browser.size(390, 800)
    try:
        browser.open(file)
        chart, size = (
            browser.run(f"(() => {{ {words} }})()")
            for words in (
                "const { data, series } = plymotion.charts[0];"
                "return [...data.slice(1), series.map((each) => each.label)];",
                "const svg = document.querySelector('svg.orbit');"
                "return svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;",
            )
        )
        assert browser.errors() == []
    finally:
        browser.size(1280, 900)
    soft, rigid, labels = chart
    assert soft[0] is None
    assert soft[3] is None
    np.testing.assert_allclose([soft[1], soft[2], soft[4]], np.log10([20.0, 2000.0, 30.0]))
    assert rigid == [None] * 5
    assert labels[1:] == ["soft", "rigid: no stress"]
    assert size >= 0.99  # text in the size of the page


def stressed(strength: PlyStrength | YieldStrength, stress: np.ndarray) -> RunResult:
    """A run whose only site has, at each time, the stress (t, 6) that its six modes are."""
    rod = swinging_rod(k=TIMES)
    one = np.zeros((1, 6, 6))
    one[0] = np.eye(6)
    none = np.zeros(0, dtype=np.int64)
    sites = Sites(
        place_B=np.zeros((1, 3)),
        resultants_E=one,
        kind=np.zeros(1, dtype=np.int64),
        compliance=one,
        stress_M=one,
        point_kind=np.zeros(1, dtype=np.int64),
        point_ply=np.zeros(1, dtype=np.int64),
        plies=(
            {"region": "a", "index": 0, "material": "m", "angle_deg": 0.0}
            | {"strength": vars(strength)},
        ),
    )
    triangle = Surface(
        np.arange(3),
        np.zeros((3, 3)),
        np.array([[0, 1, 2]]),
        np.array([7]),
        np.zeros((1, 3), dtype=np.int64),
    )
    nothing = Surface(
        none,
        np.zeros((0, 3)),
        np.zeros((0, 3), dtype=np.int64),
        none,
        np.zeros((0, 3), dtype=np.int64),
    )
    bodies = []
    for body in rod.bodies:
        n, held = len(body.nodes_B), body.name == "rod"
        bodies.append(
            dataclasses.replace(
                body,
                view=BodyView(
                    first_position=0,
                    shapes_B=np.zeros((6 if held else 0, n, 6)),
                    stiffness=np.eye(6 if held else 0),
                    frequencies=np.ones(6 if held else 0),
                    labels=tuple("abcdef") if held else (),
                    mass=1.0,
                    centre_B=np.zeros(3),
                    draw=(lambda: triangle) if held else (lambda: nothing),
                    sites=sites if held else None,
                ),
            )
        )
    return dataclasses.replace(rod, q=np.hstack([rod.q, stress]), bodies=tuple(bodies))


@pytest.mark.parametrize("strength", [PLY, METAL], ids=["ply", "metal"])
def test_every_criterion(
    browser: Browser, strength: PlyStrength | YieldStrength, tmp_path: Path
) -> None:
    """Random stresses in which each criterion governs somewhere."""
    rng = np.random.default_rng(3)
    sizes = [10.0, 1.0, 1.0, 0.5, 0.5, 0.5] * rng.choice([0.0, 1.0], size=(TIMES, 6))
    stress = rng.normal(size=(TIMES, 6)) * sizes
    stress[0] = 0.0
    result = stressed(strength, stress)
    (tmp_path / "rod").mkdir()
    write_result(tmp_path / "rod/result.vtkhdf", result)
    summary: dict[str, Any] = {"run": "rod", "completed": True, "t_end": float(result.t[-1])}
    write_summary(tmp_path / "rod/summary.json", summary)
    browser.open(make_report(tmp_path, ["rod"], {}))
    shown = exposures(browser, 0, result.t.tolist())[:, 0]
    criteria = criteria_of(strength)
    every = np.array([c.assess(stress, strength).exposure for c in criteria])
    sites = result.bodies[0].view.sites  # type: ignore[union-attr]
    exact = site_exposure(sites, stress)[:, 0]
    np.testing.assert_allclose(exact, every.max(axis=0), rtol=1e-12)
    half_step = exact.max() / 255 / 2  # the page has steps of its colours
    np.testing.assert_allclose(shown, exact, rtol=0, atol=1.001 * half_step)
    governing = {criteria[k].name for k in np.argmax(every, axis=0)[1:]}
    assert governing == {c.name for c in criteria}, "the stresses do not reach every criterion"
    for mode in (1, 5):
        alone = np.where(np.arange(6) == mode, stress, 0.0)
        expected = np.max([c.assess(alone, strength).exposure for c in criteria], axis=0)
        shown = exposures(browser, 0, result.t.tolist(), mode)[:, 0]
        np.testing.assert_allclose(shown, expected, rtol=2e-5, atol=1e-6)
