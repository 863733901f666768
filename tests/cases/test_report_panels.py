"""The report of the antenna panel in Chromium: bodies at the same place, and a rigid body."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from harness.chromium import SOFTWARE, Browser
from samples.case_samples import short_run

from plymotion.solver.__main__ import main

COUNT = """(() => {
  const { view, drawView } = plymotion;
  view.camera.yaw = %(yaw)g;
  drawView();
  const { canvas } = view.renderer, flat = document.createElement('canvas');
  [flat.width, flat.height] = [canvas.width, canvas.height];
  const pen = flat.getContext('2d');
  pen.drawImage(canvas, 0, 0);
  const bytes = pen.getImageData(0, 0, flat.width, flat.height).data;
  const found = { blue: 0, orange: 0, green: 0 };
  for (let i = 0; i < bytes.length; i += 4) {
    const [r, g, b] = bytes.subarray(i, i + 3);
    if (b > g + 30 && g > r) found.blue++;
    if (r > g + 30 && g > b) found.orange++;
    if (g > r + 30 && g > b) found.green++;
  }
  return found;
})()"""


@pytest.fixture(scope="module")
def browser(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The antenna panel at its start, both panels folded on each other."""
    folder = tmp_path_factory.mktemp("case")
    short_run(repository, "antenna-panel", "deployment", folder, 0.01)
    assert main(["report", str(folder)]) == 0
    with Browser(folder / "profile", *SOFTWARE) as opened:
        opened.open(folder / "report.html")
        opened.run("plymotion.clock.set(0)")
        yield opened


@pytest.mark.parametrize("yaw", [0.2, 0.6, -1.2, 2.5])
def test_of_two_panels_at_the_same_place_the_first_is_seen(browser: Browser, yaw: float) -> None:
    found = browser.run(COUNT % {"yaw": yaw})
    assert found["orange"] > 5000
    assert found["green"] == 0


def test_the_satellite_is_as_large_as_its_inertia_says(browser: Browser) -> None:
    assert browser.run(COUNT % {"yaw": 0.6})["blue"] > 20_000
