"""The section of report.html on runs with [fidelity]."""

import copy
import json
import xml.etree.ElementTree as ET
from types import SimpleNamespace

import pytest

from plymotion.solver.report.fidelity import chart, fidelity_section, ladder_file, with_ladder
from plymotion.solver.report.report_data import Story

LADDER = {
    "rungs": [
        {"name": "rigid", "cpu": 0.01, "error": 0.2},
        {"name": "1 mode", "cpu": 0.02, "error": 3e-3},
        {"name": "slow and poor", "cpu": 0.5, "error": 5e-2},
        {"name": "exact", "cpu": 0.6, "error": 0.0},
    ],
    "chosen": {"name": "chosen", "cpu": 0.03, "error": 2e-3},
    "check": {"name": "check", "cpu": 0.2, "error": 1e-4},
    "estimate": 2.1e-3,
    "asked": 1e-2,
}
PLAN = {
    "rtol": 1e-5,
    "geometric_stiffening": True,
    "bodies": {
        "arm": {
            "vibrations": ["bending-xy 1"],
            "static_shapes": 2,
            "ringing": False,
            "mesh": "model",
        },
        "hand": {"vibrations": [], "static_shapes": 0, "ringing": False, "mesh": "model"},
    },
}
FOUND = {
    "asked": 1e-2,
    "metric": "pointwise",
    "scale": {"tip_<x>": 1.5, "force": 20.0},
    "plan": PLAN,
    "estimate": {"tip_<x>": 2.1e-3, "force": None},
    "delivered": {"run": "all modes", "error_at_most": {"tip_<x>": 2.2e-3, "force": None}},
    "shares": [{"kind": "statics", "body": "arm", "value": 4e-3}],
    "rounds": 1,
    "cpu": {"plan": 0.1, "model": 0.2, "check": 0.3},
    "verdict": "not met",
    "reason": "the check differs by 0.02",
    "base": "rigid",
    "horizon": 0.25,
    "not_checked": ["the joints & their play"],
    "ladder": LADDER,
}


def story(**changes):
    summary = {"fidelity": {**copy.deepcopy(FOUND), **changes}}
    return Story("base", "Base", summary, SimpleNamespace())


def test_the_section_has_what_was_asked_and_found():
    text = fidelity_section([story(), Story("other", "Other", {}, SimpleNamespace())])
    for words in (
        "tip_&lt;x&gt;", "NOT met", "2.1e-03", "bending-xy 1", "2, damped", "rigid",
        "the joints &amp; their play", "t = 0.25 s", "statics", "4.0e-03", "no bound", "0.6",
        "all modes", "2.2e-03", "not estimated",
    ):  # fmt: skip
        assert words in text
    assert "Other" not in text
    assert fidelity_section([Story("other", "Other", {}, SimpleNamespace())]) == ""


def test_the_chart_has_the_models_their_front_and_what_was_asked():
    root = ET.fromstring(chart(LADDER, "a & b"))
    symbols = {g.get("class"): g.find("title").text for g in root.iter("g")}
    assert set(symbols) == {"fid-model", "fid-chosen", "fid-check"}
    titles = [g.find("title").text for g in root.iter("g")]
    assert len(titles) == 5  # no place for an error of zero
    front = root.find("polyline").get("points").split()
    assert len(front) == 4  # the slow and poor model is not on it
    across = [float(point.split(",")[0]) for point in front]
    down = [float(point.split(",")[1]) for point in front]
    assert across == sorted(across)
    assert down == sorted(down)
    assert "style" not in chart(LADDER, "a")


def test_a_chart_without_points_is_left_out():
    empty = {**LADDER, "rungs": [], "chosen": LADDER["rungs"][3], "check": LADDER["rungs"][3]}
    assert chart(empty, "a") == ""


@pytest.mark.parametrize(("asked", "taken"), [(1e-2, True), (1e-3, False)])
def test_the_models_of_the_chart_command_are_shown_with_their_plan_only(tmp_path, asked, taken):
    file = ladder_file(tmp_path, "base")
    file.parent.mkdir()
    rungs = [{"name": "of the chart", "cpu": 0.1, "error": 0.1}]
    file.write_text(json.dumps({**LADDER, "rungs": rungs, "plan": PLAN, "asked": asked}))
    text = fidelity_section([with_ladder(tmp_path, story())])
    assert ("of the chart" in text) == taken
    assert ("slow and poor" in text) != taken


@pytest.mark.parametrize("text", ["", '{"plan": {', "[]", "{}", "null"])
def test_a_damaged_file_of_the_chart_command_is_left_out(tmp_path, text):
    file = ladder_file(tmp_path, "base")
    file.parent.mkdir()
    file.write_text(text)
    assert "slow and poor" in fidelity_section([with_ladder(tmp_path, story())])
