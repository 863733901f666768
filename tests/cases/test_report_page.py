"""report.html in a real headless Chromium: what it draws, computes, and does when used."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from harness.chromium import NO_3D, SOFTWARE, Browser

from plymotion.solver.__main__ import main
from plymotion.solver.math.rotations import rotation_matrix
from plymotion.solver.report.report_data import read_story
from plymotion.solver.report.report_page import page
from plymotion.solver.report.scene import site_energy
from plymotion.solver.results import RunResult, read_result

pytest.importorskip("matplotlib")

RUNS = ("layup-1", "layup-2")
LONG_TITLE = "lay-up 2, all plies 30 deg, a title that is too long for <small> & narrow screens"


@pytest.fixture(scope="module")
def case_dir(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped double pendulum, 0.1 s of two of its runs, with their report."""
    folder = tmp_path_factory.mktemp("case")
    text = (repository / "cases/double-pendulum/case.toml").read_text()
    assert "t_end = 1.0" in text
    text = text.replace("t_end = 1.0", "t_end = 0.1")
    assert LONG_TITLE not in text
    text = text.replace("lay-up 2, all plies 30 deg", LONG_TITLE)
    text += (
        '\n[figures.orbit]\ntitle = "Path <b>of</b> the tip"\nsignal = "tip_y"\nagainst = "tip_x"\n'
    )
    text += f"runs = {list(RUNS)}\n".replace("'", '"')
    (folder / "case.toml").write_text(text)
    packages = repository / "tests/packages/double-pendulum"
    runs = [word for run in RUNS for word in ("--run", run)]
    command = [str(folder / "case.toml"), *runs, "--packages", str(packages), "--quiet"]
    assert main([*command, "--out", str(folder / "build"), "--jobs", "1"]) == 0
    return folder / "build"


@pytest.fixture(scope="module")
def browser(case_dir: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("browser") / "profile", *SOFTWARE) as opened:
        opened.open(case_dir / "report.html")
        yield opened


ORBIT = """(() => {
  const { clock, page, array } = plymotion, svg = document.querySelector('svg.orbit');
  clock.set(0.05);
  const all = (name) => [...svg.querySelectorAll(name)];
  const dots = all('circle').map((dot) => [dot.cx, dot.cy].map((v) => v.baseVal.value));
  const curves = all('polyline').map((line) => [...line.points].map((p) => [p.x, p.y]));
  clock.set(0);
  return { dots, curves, title: svg.closest('figure').querySelector('h3').textContent };
})()"""


def test_one_signal_against_another(browser: Browser, case_dir: Path) -> None:
    """Its curve is an image of both signals at one scale; the dot is at the time that is shown."""
    found = browser.run(ORBIT)
    assert found["title"] == "Path <b>of</b> the tip"
    for run, dot, curve in zip(RUNS, found["dots"], np.array(found["curves"]), strict=True):
        result = read_result(case_dir / run / "result.vtkhdf")
        x, y = (next(s.values for s in result.signals if s.name == n) for n in ("tip_x", "tip_y"))
        scale = np.ptp(curve[:, 0]) / np.ptp(x)
        np.testing.assert_allclose(curve[:, 0] - curve[0, 0], scale * (x - x[0]), atol=0.2)
        np.testing.assert_allclose(curve[:, 1] - curve[0, 1], -scale * (y - y[0]), atol=0.2)
        k = int(np.searchsorted(result.t, 0.05 - 1e-9))
        np.testing.assert_allclose(dot, curve[k], atol=0.2)


def positions(result: RunResult, number: int, row: int, scale: float) -> np.ndarray:
    """Corners (c, 3) of the triangles of a body at an output time, in double precision."""
    body = result.bodies[number]
    view = body.view
    assert view is not None
    first, m = view.first_position, len(view.shapes_B)
    r, p = result.q[row, first : first + 3], result.q[row, first + 3 : first + 7]
    moved = np.einsum("m,mna->na", result.q[row, first + 7 : first + 7 + m], view.shapes_B)
    node, offset = view.surface.node, view.surface.offset_B
    swing = np.cross(moved[node, 3:], offset)
    b = body.nodes_B[node] + offset + scale * (moved[node, :3] + swing)
    return np.asarray(
        (r + b @ rotation_matrix(p / np.linalg.norm(p)).T)[view.surface.triangles.ravel()]
    )


CAPTURE = """(() => {
  const { view, page, clock, bodyState, shownNow } = plymotion;
  const { scene } = page.runs.find((run) => run.name === %(run)s);
  const body = scene.bodies[%(body)d], state = bodyState(scene, body, %(t)r, -1);
  const shown = { ...shownNow(scene), scale: %(scale)g };
  const positions = view.renderer.capture(scene, body, state, shown);
  return [Array.from(positions), scene.origin];
})()"""


ENERGY = """(() => {
  const { page, bodyState, siteValues } = plymotion;
  const { scene } = page.runs.find((run) => run.name === 'layup-2'), body = scene.bodies[0];
  return Array.from(siteValues(scene, body, bodyState(scene, body, %(t)r, %(solo)d), 'energy'));
})()"""


FLAT = """(() => {
  const { page, array, bodyState, pointsAt } = plymotion;
  const { scene } = page.runs[0], body = scene.bodies[0];
  const points = pointsAt(body, bodyState(scene, body, %(t)r, -1), %(scale)g);
  const corner = (k) => [0, 1, 2].map((a) => points[3 * k + a] + scene.origin[a]);
  return [...array(body.triangles)].flatMap(corner);
})()"""


def captured(browser: Browser, run: str, body: int, t: float, scale: float) -> np.ndarray:
    """What the GPU computes: corners (c, 3) in global axes."""
    words = {"run": json.dumps(run), "body": body, "t": t, "scale": scale}
    corners, origin = browser.run(CAPTURE % words)
    return np.reshape(corners, (-1, 3)) + origin


def test_a_page_that_would_be_too_large_has_fewer_animations(
    case_dir: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stories = [read_story(case_dir, run, f"run {run}") for run in RUNS]
    sizes = {}
    for limit, moving in ((10**9, [True, True]), (None, [True, False]), (0, [False, False])):
        room = sizes[10**9] - 1000 if limit is None else limit
        monkeypatch.setattr("plymotion.solver.report.report_page.LIMIT", room)
        text = page("pendulum", stories, [])
        sizes[limit] = len(text.encode())
        index = json.loads(text.split("id='index'>")[1].split("</script>")[0])
        assert [run["scene"] is not None for run in index["runs"]] == moving
        assert ("Without animation, to keep the page small: run layup-2" in text) == (limit is None)
    assert sizes[0] < sizes[None] < sizes[10**9] - 1000


def test_it_draws_with_webgl(browser: Browser) -> None:
    assert browser.run("document.documentElement.dataset.ready") == "yes"
    assert browser.run("document.documentElement.dataset.renderer") == "webgl2"


@pytest.mark.parametrize("run", RUNS)
@pytest.mark.parametrize("scale", [1.0, 20.0])
def test_positions_on_the_gpu_agree_with_numpy(
    browser: Browser, case_dir: Path, run: str, scale: float
) -> None:
    result = read_result(case_dir / run / "result.vtkhdf")
    for row in (0, len(result.t) // 2, len(result.t) - 1):
        for number, body in enumerate(result.bodies):
            assert body.view is not None
            corners = captured(browser, run, number, float(result.t[row]), scale)
            expected = positions(result, number, row, scale)
            # Joints come after the surface.
            np.testing.assert_allclose(corners[: len(expected)], expected, rtol=0, atol=1e-6)
            if row and scale > 1.0 and number == 0:
                # The comparison would notice a wrong sign of the deformation, or of a rotation.
                flipped = positions(result, number, row, -scale)
                assert np.abs(corners[: len(expected)] - flipped).max() > 1e-4


def test_strain_energy_of_the_page_agrees_with_numpy(browser: Browser, case_dir: Path) -> None:
    result = read_result(case_dir / "layup-2/result.vtkhdf")
    row = len(result.t) - 1
    view = result.bodies[0].view
    assert view is not None
    assert view.sites is not None
    q = result.q[row, view.first_position + 7 :][: len(view.shapes_B)]
    F = view.sites.resultants_E @ q
    expected = 0.5 * np.einsum("si,ij,sj->s", F, view.sites.compliance[0], F)
    shown = browser.run(ENERGY % {"t": float(result.t[row]), "solo": -1})
    energies = site_energy(view.sites, result.q[:, view.first_position + 7 :][:, : len(q)])
    np.testing.assert_allclose(energies[row], expected, rtol=0, atol=1e-12 * expected.max())
    half_step = energies.max() / 255 / 2  # the page has steps of its colours
    np.testing.assert_allclose(shown, expected, rtol=0, atol=1.001 * half_step)
    for mode in range(len(q)):
        F = view.sites.resultants_E[:, :, mode] * q[mode]
        alone = 0.5 * np.einsum("si,ij,sj->s", F, view.sites.compliance[0], F)
        shown = browser.run(ENERGY % {"t": float(result.t[row]), "solo": mode})
        np.testing.assert_allclose(shown, alone, rtol=0, atol=1e-5 * alone.max())
    # The densities add up to the energy of the modes: the trapezium rule along the beam.
    x = view.sites.place_B[:, 0]
    total = np.sum(0.5 * (expected[1:] + expected[:-1]) * np.diff(x))
    assert total == pytest.approx(0.5 * q @ view.stiffness @ q, rel=0.02)


def test_slider_keys_and_buttons_change_time_and_picture(browser: Browser, tmp_path: Path) -> None:
    end = browser.run("plymotion.clock.end")
    browser.run("plymotion.clock.set(0)")
    before = browser.run("document.getElementById('canvas').toDataURL()")
    browser.choose("slider", "0.5", "input")
    assert browser.run("plymotion.clock.t") == pytest.approx(0.5 * end, abs=end / 50)
    assert "0.05 s" in browser.run("document.getElementById('caption').textContent")
    browser.wait(f"document.getElementById('canvas').toDataURL() !== {json.dumps(before)}")
    browser.run("document.activeElement.blur()")
    browser.key("End")
    assert browser.run("plymotion.clock.t") == end
    browser.key("ArrowLeft")
    assert browser.run("plymotion.clock.t") < end
    browser.key("Home")
    assert browser.run("plymotion.clock.t") == 0.0
    browser.choose("speed", "0.001")
    browser.click("#play")
    assert browser.run("plymotion.clock.playing") is True
    browser.wait("document.getElementById('play').textContent === 'pause'")
    browser.click("#play")
    assert browser.run("plymotion.clock.playing") is False
    browser.choose("scale", "20")
    assert "deformation 20 times" in browser.run("document.getElementById('caption').textContent")
    assert browser.errors() == []


def test_small_and_large_numbers_of_an_axis_have_powers_of_ten(browser: Browser) -> None:
    for numbers, texts in (
        ([-5.625e-6, 0, 1e-5], ["-5.625e-6", "0", "1e-5"]),
        ([0, 0.1 + 0.2, 1000], ["0", "0.3", "1000"]),
        ([0, 2.5e6], ["0", "2.5e+6"]),
    ):
        assert browser.run(f"plymotion.short(null, {numbers})") == texts
    for low, high, texts in (
        (-2.25e-7, 0.371, ["0", "0.1", "0.2", "0.3"]),
        (-1.0, 1.0, ["-1", "-0.5", "0", "0.5", "1"]),
        (2.1e-7, 3.9e-7, ["2.5e-7", "3e-7", "3.5e-7"]),
    ):
        assert browser.run(f"plymotion.short(null, plymotion.ticks({low}, {high}))") == texts


def test_tables_sort(browser: Browser) -> None:
    rows = "[...document.querySelectorAll('#runs tbody tr')]"
    names = f"{rows}.map((row) => row.cells[0].innerText)"
    steps = f"{rows}.map((row) => Number(row.cells[6].innerText))"
    before = browser.run(names)
    browser.click("#runs th:nth-child(7) button")
    assert browser.run(steps) == sorted(browser.run(steps))
    browser.click("#runs th:nth-child(7) button")
    assert browser.run(steps) == sorted(browser.run(steps), reverse=True)
    assert sorted(browser.run(names)) == sorted(before)
    assert (
        browser.run("document.querySelector('#runs th:nth-child(7)').getAttribute('aria-sort')")
        == "descending"
    )


def test_csv_has_the_signals_of_the_runs(browser: Browser, case_dir: Path, tmp_path: Path) -> None:
    browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    browser.click("#plot-list figure button:nth-child(3)")
    for _ in range(200):
        files = list(tmp_path.glob("*.csv"))
        if files:
            break
        browser.run("new Promise((done) => setTimeout(done, 50))")
    (file,) = files
    lines = file.read_text().splitlines()
    assert lines[0].split(",")[0] == "time [s]"
    rows = np.array([[float(word) for word in line.split(",")] for line in lines[1:]])
    for column, run in enumerate(RUNS, 1):
        result = read_result(case_dir / run / "result.vtkhdf")
        (signal,) = [s for s in result.signals if s.name == "arm_mid"]
        np.testing.assert_allclose(rows[:, 0], result.t, rtol=1e-6)
        np.testing.assert_allclose(rows[:, column], signal.values, rtol=1e-6, atol=1e-12)


def test_spectrum_meets_frequency_and_amplitude_of_a_vibration(browser: Browser) -> None:
    found = browser.run("""(() => {
      const w = 2 * Math.PI, t = Float64Array.from({ length: 2001 }, (_, i) => i / 1000);
      const y = t.map((s) => 5 + 0.25 * Math.sin(w * 43.7 * s) + 0.01 * Math.sin(w * 120 * s));
      const { frequency, amplitude } = plymotion.spectrum(t, y, 0, 2);
      return [Array.from(frequency), Array.from(amplitude)];
    })()""")
    frequency, amplitude = np.array(found)
    top = int(np.argmax(amplitude))
    assert frequency[top] == pytest.approx(43.7, abs=0.1)
    assert amplitude[top] == pytest.approx(0.25, rel=0.01)
    near = np.abs(frequency - 120.0) < 2.0
    assert amplitude[near].max() == pytest.approx(0.01, rel=0.02)
    browser.click("#plot-list figure button:nth-child(2)")
    browser.wait("document.querySelector('#plot-list figure .chart:last-child canvas') !== null")
    assert browser.errors() == []


def test_nothing_else_is_asked_for_and_nothing_complains(browser: Browser, case_dir: Path) -> None:
    assert browser.requests() == [(case_dir / "report.html").resolve().as_uri()]
    assert browser.errors() == []


def test_page_prints_with_stills_of_the_motion(browser: Browser, tmp_path: Path) -> None:
    browser.run("window.dispatchEvent(new Event('beforeprint'))")
    shades = browser.shades("#stills canvas")
    assert len(shades) == 4
    assert min(shades) > 8, "an empty picture"
    browser.run("window.dispatchEvent(new Event('afterprint'))")
    paper = browser.pdf(tmp_path / "report.pdf").read_bytes()
    assert paper.startswith(b"%PDF")
    assert len(paper) > 50_000
    assert browser.errors() == []


def test_page_is_usable_without_3d(case_dir: Path, tmp_path: Path) -> None:
    with Browser(tmp_path / "profile", *NO_3D) as plain:
        plain.open(case_dir / "report.html")
        assert plain.run("document.documentElement.dataset.renderer") == "canvas2d"
        assert plain.run("document.querySelector('#colour option[value=energy]').disabled") is True
        plain.wait("document.getElementById('canvas').width > 300")
        assert plain.shades("#canvas")[0] > 8, "an empty picture"
        result = read_result(case_dir / "layup-1/result.vtkhdf")
        row = len(result.t) // 2
        found = plain.run(FLAT % {"t": float(result.t[row]), "scale": 5.0})
        expected = positions(result, 0, row, 5.0)
        np.testing.assert_allclose(
            np.reshape(found, (-1, 3))[: len(expected)], expected, rtol=0, atol=1e-6
        )
        assert plain.errors() == []


@pytest.mark.parametrize("dark", [False, True])
def test_no_serious_findings_on_accessibility(
    repository: Path, case_dir: Path, tmp_path: Path, *, dark: bool
) -> None:
    axe = repository / "build/browser/axe.min.js"
    if not axe.is_file():
        pytest.skip("no axe-core: tools/browser.sh build/browser installs it")
    with Browser(tmp_path / "profile", *SOFTWARE, dark=dark) as other:
        other.open(case_dir / "report.html")
        other.run(axe.read_text() + "; 0")
        found = other.run(
            "axe.run(document).then(({ violations, passes }) => [passes.length,"
            "violations.map((v) => [v.impact, v.id, v.nodes.map((n) => n.html)])])"
        )
    passed, violations = found
    assert passed > 20
    assert [each for each in violations if each[0] in ("serious", "critical")] == []


def test_nothing_is_cut_off_on_a_narrow_screen(browser: Browser) -> None:
    browser.size(375, 800)
    browser.wait("document.documentElement.clientWidth === 375")
    try:
        assert browser.run("document.documentElement.scrollWidth") <= 375
        browser.wait("document.getElementById('canvas').getBoundingClientRect().width < 375")
        inside = "[...document.querySelectorAll('#view select, #view button, #view input')]"
        assert (
            browser.run(f"Math.max(...{inside}.map((e) => e.getBoundingClientRect().right))") <= 375
        )
        browser.wait("plymotion.charts.every((plot) => plot.width < 375)")
    finally:
        browser.size(1280, 900)


def test_wrong_script_is_refused_by_the_policy(case_dir: Path, tmp_path: Path) -> None:
    """The policy is in force: a script of somebody else in the page does not run."""
    text = (case_dir / "report.html").read_text()
    page = tmp_path / "report.html"
    page.write_text(text.replace("</body>", "<script>document.title = 'changed'</script></body>"))
    with Browser(tmp_path / "profile", *SOFTWARE) as other:
        other.open(page)
        assert other.run("document.title") != "changed"
        assert any("Content Security Policy" in error for error in other.errors())


def test_the_mechanism_moves_when_the_page_opens(browser: Browser, case_dir: Path) -> None:
    """At the speed nearest to real time at which 0.1 s take 2 to 20 s; not with reduced motion"""
    assert browser.run("plymotion.clock.playing") is False
    browser.reduce_motion(False)
    browser.open(case_dir / "report.html")
    browser.wait("plymotion.clock.t > 0")
    assert browser.run("plymotion.clock.speed") == 0.01
    assert browser.run("document.getElementById('speed').value") == "0.01"
    browser.reduce_motion(True)
    browser.open(case_dir / "report.html")
    assert browser.run("plymotion.clock.t") == 0.0
    # A motion that is ended and begun anew within a frame, as that of a video is, plays once.
    told = browser.run("""new Promise((done) => {
      const { clock } = plymotion;
      let frames = 0, told = 0;
      const count = () => (frames++ < 10 ? requestAnimationFrame(count) : done(told));
      clock.toggle();
      clock.playing = false;
      clock.toggle();
      clock.onChange(() => told++);
      count();
    })""")
    assert 5 < told < 15
