"""The report: its figures show the results of the runs, and the page is self-contained."""

import base64
import dataclasses
import gzip
import hashlib
import json
import re
import shutil
import sys
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from samples.result_samples import swinging_rod

from plymotion.solver.errors import InputError
from plymotion.solver.package.common.files import RECORD
from plymotion.solver.report.case_figures import draw_comparison
from plymotion.solver.report.inline import chosen_rows
from plymotion.solver.report.report_data import MOST_SIGNALS, Comparison, comparisons, read_story
from plymotion.solver.report.report_page import make_report
from plymotion.solver.report.style import house_style
from plymotion.solver.report.table import summary_table
from plymotion.solver.results import (
    ResultError,
    RunResult,
    Signal,
    signal_summary,
    write_result,
    write_summary,
)

pytest.importorskip("matplotlib")


CASE = {
    "title": "Swinging rods <long & short>",
    "runs": {"long": "long rod", "short": "short rod", "broken": "rod that stopped"},
    "figures": {
        "angles": {
            "title": "Angle of the rods",
            "signal": "angle",
            "runs": ["long", "short", "broken"],
        }
    },
}


def summary_of(result: RunResult, **extra: Any) -> dict[str, Any]:
    drift = float(np.max(np.abs(result.relative_balance)))
    return {
        "case": result.case,
        "run": result.run,
        "completed": True,
        "t_end": float(result.t[-1]),
        "signals": {s.name: signal_summary(s, result.t) for s in result.signals},
        "checks": {
            "constraint_position_max": float(result.violations["position"].max()),
            "energy_drift_relative": drift,
            "modes_used": {"rod": 0},
        },
        "cost": {
            "preprocess_s": 0.0,
            "solve_s": 0.25,
            "steps": 77,
            "evaluations": 900,
            "integrator": "rk8",
        },
        "warnings": [],
        **extra,
    }


RUNS = {
    "long": (swinging_rod("long", length=0.8), {}),
    "short": (swinging_rod("short", length=0.3), {}),
    "broken": (
        swinging_rod("broken", t_end=0.7),
        {
            "completed": False,
            "warnings": [
                {"code": "run-stopped", "message": "stopped at 0.7 s because <k> & more"},
                {"code": "run-stopped", "message": "and a second time", "t": 0.5},
            ],
        },
    ),
}


@pytest.fixture(scope="module")
def case_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("build")
    for name, (result, extra) in RUNS.items():
        (folder / name).mkdir()
        write_result(folder / name / "result.vtkhdf", result)
        write_summary(folder / name / "summary.json", summary_of(result, **extra))
    make_report(folder, list(RUNS), CASE, figures=True)
    return folder


class Page(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.open: list[str] = []
        self.cells: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [v or "" for k, v in attrs if k in ("src", "href")]
        if tag not in ("meta", "img", "br", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "td" in self.open:
            self.cells.append(data)


def test_report_leaves_figures_and_a_page_and_nothing_else(case_dir: Path) -> None:
    made = {str(p.relative_to(case_dir)) for p in case_dir.rglob("*") if p.is_file()}
    expected = {"report.html", "angles.png", "tip_x.png", "tip_y.png", "figures.json", RECORD}
    for run in RUNS:
        files = ("summary.json", "result.vtkhdf", "motion.png", "balance.png", RECORD)
        expected |= {f"{run}/{file}" for file in files}
    assert made == expected


def test_without_figures_the_page_needs_no_matplotlib(
    case_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for run in RUNS:
        shutil.copytree(case_dir / run, tmp_path / run, ignore=shutil.ignore_patterns("*.png"))
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    page = make_report(tmp_path, list(RUNS), CASE)
    assert page.read_bytes() == (case_dir / "report.html").read_bytes()
    assert not list(tmp_path.rglob("*.png"))
    with pytest.raises(InputError, match="figures need matplotlib"):
        make_report(tmp_path, list(RUNS), CASE, figures=True)


@pytest.mark.usefixtures("system")
def test_only_figures_of_other_data_are_drawn_again(case_dir: Path, tmp_path: Path) -> None:
    folder = tmp_path / "case"
    shutil.copytree(case_dir, folder)
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*.png")}
    changed, other = list(RUNS)[:2]
    result, _ = RUNS[changed]
    moved = dataclasses.replace(result, node_positions_G=result.node_positions_G + 1.0)
    write_result(folder / changed / "result.vtkhdf", moved)
    (folder / other / "balance.png").unlink()
    make_report(folder, list(RUNS), CASE)
    drawn = {path for path in folder.rglob("*.png") if path.stat().st_mtime_ns != before[path]}
    own = {folder / changed / name for name in ("motion.png", "balance.png")}
    compared = {folder / f"{name}.png" for name in ("angles", "tip_x", "tip_y")}
    assert drawn == {*own, folder / other / "balance.png", *compared}


def test_figures_are_also_svg_and_pdf_the_same_each_time(case_dir: Path, tmp_path: Path) -> None:
    (tmp_path / "case/long").mkdir(parents=True)
    shutil.copy(case_dir / "long/summary.json", tmp_path / "case/long")
    result, _ = RUNS["long"]
    drawn = tuple(s for s in result.signals if s.name == "angle")  # others take time only
    write_result(tmp_path / "case/long/result.vtkhdf", dataclasses.replace(result, signals=drawn))
    found = []
    for _ in range(2):
        make_report(tmp_path / "case", ["long"], CASE, figures=True, formats=("svg", "pdf"))
        files = [tmp_path / "case/long/motion.svg", tmp_path / "case/angles.pdf"]
        found.append([file.read_bytes() for file in files])
        assert ElementTree.fromstring(found[-1][0]).tag == "{http://www.w3.org/2000/svg}svg"
        assert found[-1][1].startswith(b"%PDF-")
        assert not list((tmp_path / "case").rglob("*.png"))
        for file in files:
            file.unlink()
    assert found[0] == found[1]


def test_page_is_well_formed_and_needs_nothing_from_outside(case_dir: Path) -> None:
    text = (case_dir / "report.html").read_text()
    page = Page(text)
    assert page.open == []
    assert set(page.links) == {"#doubts"}
    assert "id='doubts'" in text
    assert not re.search(r"@import|url\(|<script[^>]* src", text)


def test_policy_allows_the_own_script_and_style_only(case_dir: Path) -> None:
    text = (case_dir / "report.html").read_text()
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy is not None
    rules = dict(rule.strip().split(" ", 1) for rule in policy[1].split(";"))
    assert rules["default-src"] == "'none'"
    (code,) = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    (style,) = re.findall(r"<style>(.*?)</style>", text, re.DOTALL)
    for rule, content in (("script-src", code), ("style-src", style)):
        digest = base64.b64encode(hashlib.sha256(content.encode()).digest()).decode()
        assert rules[rule] == f"'sha256-{digest}'"
    assert not re.search(
        r"\son[a-z]+=|\sstyle=", re.sub(r"<(script|style).*?</\1>", "", text, flags=re.DOTALL)
    )


def arrays_of(text: str) -> tuple[dict[str, Any], Callable[[int], np.ndarray]]:
    """Index of a page, and a function that returns its arrays as the page unpacks them."""
    index = json.loads(re.search(r"id='index'>(.*?)</script>", text, re.DOTALL)[1])  # type: ignore[index]
    packed = re.search(r"id='arrays'>(.*?)</script>", text, re.DOTALL)[1]  # type: ignore[index]
    data = np.frombuffer(gzip.decompress(base64.b64decode(packed)), dtype=np.uint8)

    def array(number: int) -> np.ndarray:
        entry = index["arrays"][number]
        dtype = np.dtype(f"<{entry['type']}")
        count = int(np.prod(entry["shape"]))
        raw = data[entry["at"] : entry["at"] + count * dtype.itemsize]
        shuffled = raw.reshape(dtype.itemsize, count)
        return np.ascontiguousarray(shuffled.T).view(dtype).reshape(entry["shape"])

    return index, array


def test_page_has_every_history_of_every_run(case_dir: Path) -> None:
    index, array = arrays_of((case_dir / "report.html").read_text())
    assert [run["name"] for run in index["runs"]] == list(RUNS)
    for run in index["runs"]:
        result = RUNS[run["name"]][0]
        np.testing.assert_array_equal(array(run["t"]), result.t)
        for shown, signal in zip(run["signals"], result.signals, strict=True):
            assert (shown["name"], shown["unit"]) == (signal.name, signal.unit)
            np.testing.assert_allclose(array(shown["values"]), signal.values, rtol=1e-7)
        np.testing.assert_allclose(
            array(run["energies"][0]["values"]), result.energies["kinetic"], rtol=1e-7
        )


def test_long_histories_keep_every_extreme() -> None:
    rng = np.random.default_rng(5)
    series = [rng.normal(size=100_000), np.cos(np.linspace(0, 900, 100_000))]
    series[1][777] = np.nan
    rows = chosen_rows(series, 100_000, 4000)
    assert len(rows) <= 4100
    assert (rows[0], rows[-1]) == (0, 99_999)
    for values in series:
        for part in np.array_split(np.arange(100_000), 100):
            inside = rows[(rows >= part[0]) & (rows <= part[-1])]
            # An interval of `chosen_rows` may reach across the border of a part.
            assert np.nanmax(values[inside]) >= np.nanmax(values[part[100:-100]])
            assert np.nanmin(values[inside]) <= np.nanmin(values[part[100:-100]])
    np.testing.assert_array_equal(chosen_rows(series, 100, 100), np.arange(100))


def test_page_tells_outcome_numbers_and_warnings_in_full(case_dir: Path) -> None:
    text = (case_dir / "report.html").read_text()
    assert "Swinging rods &lt;long &amp; short&gt;" in text
    assert "2 of 3 runs completed" in text
    assert "data-run='broken' data-time='0.5'>show" in text  # of its own run
    assert "stopped at 0.7 s because &lt;k&gt; &amp; more" in text
    assert "and a second time" in text
    final = RUNS["long"][0].signals[0].values[-1]
    assert f"{final:.5g}" in Page(text).cells


def test_report_again_gives_the_same_bytes(case_dir: Path) -> None:
    files = [*case_dir.glob("*.png"), *case_dir.glob("*/*.png"), case_dir / "report.html"]
    before = {file: file.read_bytes() for file in files}
    make_report(case_dir, list(RUNS), CASE)
    assert before == {file: file.read_bytes() for file in files}


def test_page_is_made_again_only_if_something_changed(case_dir: Path, tmp_path: Path) -> None:
    folder = tmp_path / "case"
    shutil.copytree(case_dir, folder)
    page = folder / "report.html"
    before = page.stat().st_mtime_ns
    make_report(folder, list(RUNS), CASE)
    assert page.stat().st_mtime_ns == before
    summary = json.loads((folder / "long/summary.json").read_text())
    write_summary(folder / "long/summary.json", summary | {"t_end": 1.75})
    make_report(folder, list(RUNS), CASE)
    assert "completed, 1.75 s" in page.read_text()
    (folder / "angles.png").unlink()
    make_report(folder, list(RUNS), CASE)
    assert (folder / "angles.png").is_file()


def test_long_runs_keep_the_page_small(tmp_path: Path) -> None:
    """A hundred thousand output times, and noise that no compression makes smaller."""
    result = swinging_rod("long", k=100_000)
    rng = np.random.default_rng(1)
    noise = Signal("noise", "m", "", rng.normal(size=100_000))
    result = dataclasses.replace(result, signals=(*result.signals, noise))
    (tmp_path / "long").mkdir()
    write_result(tmp_path / "long/result.vtkhdf", result)
    write_summary(tmp_path / "long/summary.json", summary_of(result))
    text = make_report(tmp_path, ["long"], {}).read_text()
    assert len(text) < 3_000_000
    index, array = arrays_of(text)
    (run,) = index["runs"]
    shown = array(run["signals"][-1]["values"])
    assert 1000 < len(shown) < 100_000
    assert shown.max() == np.float32(noise.values.max())


def test_report_without_a_case_draws_every_signal(case_dir: Path, tmp_path: Path) -> None:
    stories = [read_story(case_dir, run, run) for run in RUNS]
    wanted = comparisons({}, stories)
    assert [c.signal for c in wanted] == ["tip_x", "tip_y", "angle"]
    assert all(set(c.runs) == set(RUNS) for c in wanted)


def test_figures_show_only_runs_that_exist(case_dir: Path) -> None:
    stories = [read_story(case_dir, "long", "long rod")]
    wanted = comparisons(CASE, stories)
    assert all(each.runs == ("long",) for each in wanted)


def test_figures_come_before_the_signals_that_they_do_not_show(case_dir: Path) -> None:
    stories = [read_story(case_dir, run, run) for run in RUNS]
    wanted = comparisons(CASE, stories)
    assert [(c.name, c.signal, c.more) for c in wanted] == [
        ("angles", "angle", False),
        ("tip_x", "tip_x", True),
        ("tip_y", "tip_y", True),
    ]


@pytest.mark.parametrize(
    ("runs", "case", "words"),
    [
        ([], CASE, "no runs"),
        (["longer"], CASE, "summary.json"),
        (
            ["long"],
            {"figures": {"f": {"title": "", "signal": "angel", "runs": ["long"]}}},
            "'angle'",
        ),
    ],
)
def test_report_names_bad_input(
    case_dir: Path, runs: list[str], case: dict[str, Any], words: str
) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        make_report(case_dir, runs, case)


def test_summary_of_another_run_is_refused(case_dir: Path, tmp_path: Path) -> None:
    (tmp_path / "long").mkdir()
    (tmp_path / "long/summary.json").write_bytes((case_dir / "short/summary.json").read_bytes())
    with pytest.raises(ResultError, match="expected 'long', found 'short'"):
        read_story(tmp_path, "long", "")


def test_table_is_aligned_and_complete() -> None:
    text = summary_table([summary_of(result, **extra) for result, extra in RUNS.values()])
    outcome, signals = (block.splitlines() for block in text.split("\n\n"))
    assert [line.split()[:2] for line in outcome[3:]] == [
        ["long", "yes"],
        ["short", "yes"],
        ["broken", "NO"],
    ]
    assert "run-stopped x2" in outcome[-1]
    assert len({line.rstrip().rfind(" ") for line in signals[3:]}) == 1, "last column not aligned"
    for line, (result, _) in zip(signals[3:], RUNS.values(), strict=True):
        numbers = [float(word) for word in line.split()[1:]]
        expected = [
            value
            for s in result.signals
            for value in (s.values[-1], s.values.min(), s.values.max())
        ]
        np.testing.assert_allclose(numbers, expected, rtol=5.1e-4)


def test_table_of_runs_with_missing_numbers() -> None:
    bare = {"run": "a", "signals": {"x": {"unit": "m", "final": None, "min": None, "max": None}}}
    text = summary_table([bare])
    assert text.splitlines()[3].split()[:3] == ["a", "NO", "-"]
    assert summary_table([]) == "no runs"


def ink(path: Path, rgb: tuple[int, int, int]) -> int:
    """Count pixels of one colour in a PNG, as a reader would see a curve."""
    from matplotlib.image import imread

    pixels = np.round(imread(path)[:, :, :3] * 255).astype(int)
    return int(np.sum(np.all(pixels == rgb, axis=2)))


def test_every_run_has_its_own_colour_and_stops_are_red(case_dir: Path, tmp_path: Path) -> None:
    """The picture holds ink of each series, and red only where a run stopped."""
    stories = [read_story(case_dir, run, run) for run in RUNS]
    blue, red = (0x00, 0x72, 0xB2), (0xB0, 0x00, 0x20)
    with house_style():
        whole = draw_comparison(
            tmp_path / "two.png", Comparison("c", "c", "angle", ("long", "short")), stories[:2]
        )
        cut = draw_comparison(
            tmp_path / "all.png", Comparison("c", "c", "angle", tuple(RUNS)), stories
        )
    for shade in (blue, (0xD5, 0x5E, 0x00)):
        assert ink(whole, shade) > 200
    assert ink(cut, (0x00, 0x9E, 0x73)) > 100
    assert ink(whole, red) == 0
    assert ink(cut, red) > 50


def test_summary_files_are_plain_json(case_dir: Path) -> None:
    for run in RUNS:
        assert json.loads((case_dir / run / "summary.json").read_text())["run"] == run


def test_a_page_shows_the_first_of_many_signals_and_those_of_figures(tmp_path: Path) -> None:
    """The time to look up the signals of all plots grew with the square of their number."""
    run, count, last = "long", MOST_SIGNALS + 50, f"s{MOST_SIGNALS + 49}"
    result = swinging_rod(run)
    one = result.signals[0]
    many = tuple(dataclasses.replace(one, name=f"s{i}") for i in range(count))
    (tmp_path / run).mkdir()
    write_result(tmp_path / run / "result.vtkhdf", dataclasses.replace(result, signals=many))
    entry = {"unit": one.unit, "final": 1.0}
    summary = summary_of(result) | {"signals": {s.name: entry for s in many}}
    write_summary(tmp_path / run / "summary.json", summary)
    text = make_report(tmp_path, [run], {}).read_text()
    assert "50 more signals are not shown" in text
    assert f"<code>s{MOST_SIGNALS - 1}</code>" in text
    assert last not in text
    figure = {"title": "one", "signal": last, "runs": [run]}
    text = make_report(tmp_path, [run], {"figures": {"one": figure}}).read_text()
    assert "49 more signals are not shown" in text
    assert f"<code>{last}</code>" in text
