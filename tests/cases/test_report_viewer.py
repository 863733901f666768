"""The view of report.html: files, arrows, colours, two runs side by side, the first screen."""

import base64
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from harness.chromium import SOFTWARE, Browser
from samples.case_samples import HEAD, SOLVER, rigid

from plymotion.solver.__main__ import main
from plymotion.solver.results import read_result

RUNS = {
    "slider-crank": ("rigid", "carbon-30"),
    "robot-arm": ("base", "rigid"),
    "double-pendulum": ("layup-1",),
    "actuated-beam": ("layup-1",),
    "spinning-plate": (),
}


def report_of(case: str, repository: Path, folder: Path) -> Path:
    """The report of a tenth of the time of some runs of a shipped case."""
    text = (repository / f"cases/{case}/case.toml").read_text()
    text = re.sub(r"(t_end = )([\d.]+)", lambda m: f"{m[1]}{0.1 * float(m[2]):g}", text)
    (folder / "meshes").symlink_to(repository / "meshes")
    for name in ("sections", "shells", case):
        shutil.copytree(repository / "cases" / name, folder / "cases" / name)
    file = folder / "cases" / case / "case.toml"
    file.write_text(text)
    words = [word for run in RUNS[case] for word in ("--run", run)]
    packages = ["--packages", str(repository / "tests/packages" / case)]
    command = [str(file), *words, *packages, "--quiet", "--jobs", "1"]
    assert main([*command, "--out", str(folder / "build")]) == 0
    return folder / "build"


@pytest.fixture(scope="module")
def crank(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report_of("slider-crank", repository, tmp_path_factory.mktemp("crank"))


@pytest.fixture(scope="module")
def arm(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report_of("robot-arm", repository, tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def browser(crank: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("browser") / "profile", *SOFTWARE) as opened:
        opened.open(crank / "report.html")
        yield opened


def saved(browser: Browser, folder: Path, pattern: str) -> Path:
    """The one file that the browser has saved in a folder, complete."""
    until = time.monotonic() + 60.0
    while time.monotonic() < until:
        files = [file for file in folder.glob(pattern) if file.stat().st_size]
        if files and not list(folder.glob("*.crdownload")):
            (file,) = files
            return file
        browser.run("new Promise((done) => setTimeout(done, 50))")
    raise AssertionError(f"no {pattern} in {folder}")


def test_loads_of_a_result_are_the_reactions_of_its_signals(crank: Path) -> None:
    result = read_result(crank / "carbon-30/result.vtkhdf")
    assert result.loads is not None
    (pin,) = [signal for signal in result.signals if signal.name == "pin_force"]
    force = result.loads.load_G[:, result.loads.names.index("pin"), :3]
    there = np.interp(result.loads.t, result.t, pin.values)
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), there, rtol=1e-9)
    # Actio at the joint's place: that of the crank's pin, one crank radius from the axis.
    place = result.loads.place_G[:, result.loads.names.index("pin")]
    np.testing.assert_allclose(np.linalg.norm(place, axis=1), 0.15, rtol=1e-9)


def test_arrows_have_the_forces_of_the_result(browser: Browser, crank: Path) -> None:
    result = read_result(crank / "rigid/result.vtkhdf")
    assert result.loads is not None
    t = float(result.loads.t[len(result.loads.t) // 2])
    found = browser.run(f"""['place', 'force', 'moment'].map((name) =>
      plymotion.vectorsAt(plymotion.page.runs[0].scene.loads, name, {t!r}))""")
    row = int(np.argmin(np.abs(result.loads.t - t)))
    origin = browser.run("plymotion.page.runs[0].scene.origin")
    places = result.loads.place_G[row] - origin
    expected = (places, result.loads.load_G[row, :, :3], result.loads.load_G[row, :, 3:])
    for shown, each in zip(found, expected, strict=True):
        step = max(np.abs(each).max(), 1.0) * 1e-3
        np.testing.assert_allclose(shown, each, rtol=0, atol=step)
    browser.choose("loads", "force")
    caption = browser.run("document.getElementById('caption').textContent")
    longest = np.linalg.norm(result.loads.load_G[:, :, :3], axis=2).max()
    assert float(caption.split("longest force ")[1].split()[0]) == pytest.approx(longest, rel=5e-3)
    browser.choose("loads", "")


OVERLAY = "document.getElementById('overlay').toDataURL()"


def test_arrows_and_paths_are_drawn(browser: Browser) -> None:
    browser.run("plymotion.clock.set(plymotion.clock.end)")
    browser.run("plymotion.drawView()")
    plain = browser.run(OVERLAY)
    for action in ("loads", "paths"):
        if action == "loads":
            browser.choose("loads", "force")
        else:
            browser.click("#paths")
        browser.run("plymotion.drawView()")
        assert browser.run(OVERLAY) != plain, action
    browser.choose("loads", "")
    browser.click("#paths")
    browser.run("plymotion.drawView()")
    assert browser.run(OVERLAY) == plain


INSIDE = """(() => {
  const { page, view, bodyState, pointsAt, shownNow, projected, cameraMatrix, clock } = plymotion;
  const { scene } = page.runs.find((run) => run.name === document.getElementById('view-run').value);
  const shown = shownNow(scene), matrix = cameraMatrix(view.camera, shown.aspect);
  const at = scene.bodies.flatMap((body) => {
    const points = pointsAt(body, bodyState(scene, body, clock.t, -1), shown.scale), found = [];
    for (let k = 0; k < points.length; k += 3)
      found.push(projected(matrix, points.subarray(k, k + 3), 1, 1));
    return found;
  });
  return [0, 1].flatMap((a) => [Math.min, Math.max].map((f) => f(...at.map((p) => p[a]))));
})()"""


@pytest.mark.parametrize("scale", ["1", "100"])
def test_the_whole_motion_is_in_the_picture_after_scaling(browser: Browser, scale: str) -> None:
    browser.choose("view-run", "carbon-30")
    browser.choose("scale", scale)
    try:
        widest = 0.0
        for part in (0.0, 0.25, 0.5, 0.75, 1.0):
            browser.run(f"plymotion.clock.set({part} * plymotion.clock.end)")
            left, right, top, bottom = browser.run(INSIDE)
            assert min(left, top) > 0.0
            assert max(right, bottom) < 1.0
            widest = max(widest, right - left, bottom - top)
        assert widest > 0.5, "the mechanism fills half of the picture"
    finally:
        browser.choose("scale", "1")
        browser.choose("view-run", "rigid")


def test_two_runs_side_by_side(browser: Browser) -> None:
    browser.run("plymotion.clock.set(0.006)")
    browser.choose("view-over", "carbon-30")
    browser.choose("beside", "1")
    try:
        assert "right: graphite/epoxy, 30 deg" in browser.run(
            "document.getElementById('caption').textContent"
        )
        halves = browser.run("""(() => {
          plymotion.drawView();
          const from = document.getElementById('canvas'), flat = document.createElement('canvas');
          [flat.width, flat.height] = [from.width, from.height];
          const pen = flat.getContext('2d'), half = Math.floor(from.width / 2);
          pen.drawImage(from, 0, 0);
          const paper = pen.getImageData(0, 0, 1, 1).data.slice(0, 3).join();
          return [0, half].map((x) => {
            const { data } = pen.getImageData(x, 0, half, from.height);
            let drawn = 0;
            for (let k = 0; k < data.length; k += 4) drawn += data.slice(k, k + 3).join() !== paper;
            return drawn;
          });
        })()""")
        assert min(halves) > 500
        # The same mechanism from the same eye: nearly as many pixels on both sides.
        assert halves[0] == pytest.approx(halves[1], rel=0.3)
    finally:
        browser.choose("view-over", "")
        browser.choose("beside", "")
    assert browser.errors() == []


def test_png_has_picture_and_caption(browser: Browser, tmp_path: Path) -> None:
    browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    browser.click("#png")
    data = saved(browser, tmp_path, "*.png").read_bytes()
    assert data.startswith(b"\x89PNG")
    size = [int.from_bytes(data[k : k + 4], "big") for k in (16, 20)]
    canvas = browser.run("[document.getElementById('canvas')].map((c) => [c.width, c.height])[0]")
    assert size == canvas


def test_a_video_of_two_seconds_is_written(browser: Browser, tmp_path: Path) -> None:
    browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    browser.choose("speed", "0.001")
    browser.click("#webm")
    browser.wait("plymotion.clock.playing")
    # The film ends with the last picture, which comes late on a busy machine without a GPU.
    browser.wait("plymotion.clock.t > 0.006")
    browser.run("new Promise((done) => setTimeout(done, 500))")
    browser.click("#webm")
    file = saved(browser, tmp_path, "*.webm")
    browser.choose("speed", "1")
    assert file.read_bytes()[:4] == b"\x1a\x45\xdf\xa3"  # EBML
    page = tmp_path / "film.html"
    film = base64.b64encode(file.read_bytes()).decode()
    page.write_text(f"<html data-ready=yes><video src='data:video/webm;base64,{film}'></video>")
    with Browser(tmp_path / "profile", *SOFTWARE) as other:
        other.open(page)
        length, width = other.run("""new Promise((done) => {
          const film = document.querySelector('video');
          const tell = () =>
            Number.isFinite(film.duration) && done([film.duration, film.videoWidth]);
          film.addEventListener('durationchange', tell);
          film.currentTime = 1e6; // a film that is recorded tells its length when it was passed
          tell();
        })""")
    assert 2.0 <= length < 12.0
    assert width == browser.run("document.getElementById('canvas').width")
    assert browser.errors() == []


def test_stress_and_weakest_ply_agree_with_the_result(arm: Path, tmp_path: Path) -> None:
    result = read_result(arm / "base/result.vtkhdf")
    view = result.bodies[0].view
    assert view is not None
    assert view.sites is not None
    first, m = view.first_position + 7, len(view.shapes_B)
    row = len(result.t) - 1
    q = np.asarray(result.q[:, first : first + m])
    sites = view.sites
    assert not sites.kind.any(), "one section"
    stress = np.einsum("pij,sjm,km->kspi", sites.stress_M, sites.resultants_E, q)
    with Browser(tmp_path / "profile", *SOFTWARE) as page:
        page.open(arm / "report.html")
        found = page.run(f"""['stress', 'ply'].map((name) => {{
          const {{ page, bodyState, siteValues }} = plymotion, {{ scene }} = page.runs[0];
          const state = bodyState(scene, scene.bodies[0], {float(result.t[row])!r}, -1);
          return Array.from(siteValues(scene, scene.bodies[0], state, name));
        }})""")
        names = page.run("plymotion.page.runs[0].scene.bodies[0].sites.plies")
        page.choose("colour", "ply")
        legend = page.run("document.getElementById('legend').textContent")
        assert all(name in legend for name in names)
        assert page.errors() == []
    fibre = np.abs(stress[..., 0]).max(axis=2)
    np.testing.assert_allclose(found[0], fibre[row], rtol=0, atol=0.51 * fibre.max() / 255)
    # The weakest ply of the summary is that of one of the sites.
    assert len(found[1]) == len(sites.kind)
    assert set(found[1]) <= set(range(len(names) + 1))


@pytest.fixture(scope="module")
def screen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A browser whose size the tests change."""
    with Browser(tmp_path_factory.mktemp("screen") / "profile", *SOFTWARE) as opened:
        yield opened


@pytest.mark.parametrize("case", RUNS)
def test_the_motion_is_on_the_first_screen(
    case: str, repository: Path, tmp_path: Path, screen: Browser, request: pytest.FixtureRequest
) -> None:
    known = {"slider-crank": "crank", "robot-arm": "arm"}
    if case in known:
        folder = request.getfixturevalue(known[case])
    else:
        folder = report_of(case, repository, tmp_path)
    axe = repository / "build/browser/axe.min.js"
    screen.events.clear()
    screen.size(1280, 900)
    screen.open(folder / "report.html")
    place = "document.getElementById('canvas').getBoundingClientRect()"
    assert screen.run(f"{place}.bottom") <= 900
    screen.size(390, 900)
    screen.wait(f"{place}.width < 390")
    assert screen.run(f"{place}.height") >= 300  # the axes then lie beside the mechanism
    assert screen.run("document.documentElement.scrollWidth") <= 390
    assert screen.run(f"{place}.bottom") <= 900
    assert screen.errors() == []
    if axe.is_file():
        screen.run(axe.read_text() + "; 0")
        found = screen.run(
            "axe.run(document).then((r) => r.violations.map((v) => [v.impact, v.id]))"
        )
        assert [each for each in found if each[0] in ("serious", "critical")] == []


def test_a_spring_is_a_coil_between_its_places(browser: Browser, crank: Path, tmp_path) -> None:
    """Its ends follow the ground and the body; the place on the ground is in the picture."""
    text = (
        rigid("box", 2.0, 0.02, {"c": (0, 0, 0)}, position=(0, -0.5, 0))
        + "[ground.top]\nposition = [0.0, 0.0, 0.0]\n"
        '[forces.hanging]\nkind = "spring"\nbetween = ["ground.top", "box.c"]\n'
        "stiffness = 200.0\nlength = 0.4\n"
    )
    (tmp_path / "case.toml").write_text(HEAD + text + SOLVER.format(t_end=0.5, step=0.05, more=""))
    out = tmp_path / "build"
    assert main([str(tmp_path / "case.toml"), "--quiet", "--out", str(out)]) == 0
    result = read_result(out / "base/result.vtkhdf")
    browser.open(out / "report.html")
    try:
        browser.run("plymotion.clock.set(0.25)")
        (spring,) = browser.run(COILS)
        assert spring["coil"]
        np.testing.assert_allclose(spring["ends"][0], [0.0, 0.0, 0.0], atol=1e-6)
        np.testing.assert_allclose(spring["ends"][1], result.q[5, :3], atol=1e-6)
        drawn = browser.run(OVERLAY)
        browser.run("plymotion.page.runs[0].scene.joints.length = 0")
        browser.run("plymotion.drawView()")
        assert browser.run(OVERLAY) != drawn
    finally:
        browser.open(crank / "report.html")


COILS = """(() => {
  const { scene } = plymotion.page.runs[0], { t } = plymotion.clock;
  const states = scene.bodies.map((body) => plymotion.bodyState(scene, body, t, -1));
  return plymotion.jointLines(scene, states, 1).map(({ coil, ends }) =>
    ({ coil, ends: ends.map((p) => p.map((v, a) => v + scene.origin[a])) }));
})()"""


@pytest.mark.parametrize(
    ("extent", "up", "expected"),
    [
        ([1, 1, 1], 2, 2),  # gravity along -z
        ([1, 1, 1], 1, 1),
        ([1, 1, 1], 0, 1),  # without gravity
        ([1, 1, 0.1], 2, 1),  # flat: one looks along z
        ([1, 0.1, 1], 1, 2),
        ([0.1, 1, 1], 1, 1),
    ],
)
def test_what_is_up_in_the_picture(browser: Browser, extent, up, expected) -> None:
    """By the button for the first view."""
    before = browser.run(f"""(() => {{ const scene = plymotion.page.runs[0].scene;
        const before = [scene.extent, scene.up];
        [scene.extent, scene.up] = [{extent}, {up}];
        document.getElementById('home').click();
        return before; }})()""")
    found = browser.run("plymotion.view.camera.up")
    scene = "plymotion.page.runs[0].scene"
    browser.run(f"[{scene}.extent, {scene}.up] = {before}")
    assert found == expected
