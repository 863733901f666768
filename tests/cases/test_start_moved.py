"""Bodies that do not close their joints where the case places them: told, and how to clear it."""

import re

import numpy as np
import pytest
from samples.case_samples import case_runs, rigid, run_text
from samples.judged_samples import judged

from plymotion.solver.run.execution import read_run
from plymotion.solver.run.preparation import prepare

ENDS = {"a": (-0.5, 0, 0), "b": (0.5, 0, 0)}
PLACES = {
    "crank": ([0.0, 0.5, 0.0], [0.0, 0.0, 90.0]),
    "coupler": ([0.5, 1.0, 0.0], [0.0, 0.0, 0.0]),
    "rocker": ([1.0, 0.5, 0.0], [0.0, 0.0, 90.0]),
}


def four_bar(apart=0.0, drive="", size=1.0, **places):
    """A parallelogram of 1 m, times `size`, whose last foot stands further away [m]."""
    ends = {name: size * np.array(at) for name, at in ENDS.items()}
    text = "".join(
        rigid(name, 1.0, 0.1 * size**2, ends, position=size * np.array(at), rotation_deg=turn)
        for name, (at, turn) in (PLACES | places).items()
    )
    for name, x in (("o", 0.0), ("p", 1.0 + apart)):
        text += f"[ground.{name}]\nposition = [{size * x}, 0.0, 0.0]\n"
    hinges = [("ground.o", "crank.a"), ("crank.b", "coupler.a"), ("coupler.b", "rocker.b")]
    for k, (one, two) in enumerate([*hinges, ("ground.p", "rocker.a")]):
        key = drive if k == 0 else ""
        text += f'[joints.j{k}]\nkind = "revolute"\nbetween = ["{one}", "{two}"]\n{key}\n'
    return text


def places_to_give(message):
    """Position and rotation_deg of the bodies that a finding lists."""
    listed = re.findall(
        r"(\w+) by [^(]*\(position = \[([^]]*)\], rotation_deg = \[([^]]*)\]\)", message
    )
    return {
        name: tuple([float(x) for x in part.split(", ")] for part in parts)
        for name, *parts in listed
    }


@pytest.mark.provokes("start-moved")
def test_a_loop_that_does_not_close_where_it_is_given(tmp_path):
    found = judged(tmp_path, four_bar(0.034), t_end=0.01).finding("start-moved")
    assert found["value"] == pytest.approx(0.0230, abs=1e-3)
    assert "rocker by 0.0225 m and 1.32 deg" in found["message"]
    given = places_to_give(found["message"])
    assert len(given) == 3
    assert "start-moved" not in judged(tmp_path, four_bar(0.034, **given), t_end=0.01).codes


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_a_mechanism_starts_alike_at_any_size(tmp_path, size):
    """Tolerances in metres found no equilibrium at 1 km, and moved other bodies to close a loop."""
    for start in ("positions", "equilibrium"):
        found = []
        for by in (1.0, size):
            place = '[signals.x]\nkind = "position"\nat = "crank.b"\ncomponent = "x"\n'
            text = f'allow = ["size-units"]\ngravity = [0.0, {-9.81 * by}, 0.0]\n'
            text += f"{four_bar(0.034, size=by)}{place}"
            _, signals, summary = run_text(
                tmp_path, text, t_end=0.01, step=0.01, more=f'start = "{start}"'
            )
            codes = {w["code"]: w.get("value") for w in summary["warnings"]}
            found.append((signals["x"] / by, codes))
        np.testing.assert_allclose(found[1][0], found[0][0], atol=1e-8)
        assert found[1][1] == pytest.approx(found[0][1], rel=1e-8)


def test_a_body_off_its_plane_is_moved_and_not_turned(tmp_path):
    """Angles that are rounding are 0, not 4e-16 deg."""
    text = rigid("disc", 1.0, 0.1, ENDS, position=[0.5, 0.0, 0.034])
    text += '[ground.o]\nposition = [0.0, 0.0, 0.0]\n[joints.plane]\nkind = "planar"\n'
    text += 'between = ["ground.o", "disc.a"]\naxis = [0.0, 0.0, 1.0]\n'
    _, _, summary = run_text(tmp_path, text, t_end=0.01, step=0.01)
    (found,) = (w for w in summary["warnings"] if w["code"] == "start-moved")
    assert "disc by 0.034 m and 0 deg (position = [0.5, 0, 0]," in found["message"]


def test_the_places_to_give_are_in_the_unit_of_the_file(tmp_path):
    ground = '[ground.o]\nposition = [20.0, 0.0, 0.0]\n[joints.pin]\nkind = "revolute"\n'
    ground, place, codes = ground + 'between = ["ground.o", "bob.pin"]\n', [70.0, 0.0, 3.0], []
    for _ in range(2):
        text = rigid("bob", 1.0, 0.1, {"pin": (-50, 0, 0)}, position=place) + ground
        _, _, summary = run_text(tmp_path, 'units = "mm"\n' + text, t_end=0.01, step=0.01)
        codes.append({w["code"]: w["message"] for w in summary["warnings"]}.get("start-moved"))
        if codes[0] is not None:
            place = places_to_give(codes[0])["bob"][0]
    assert "bob by 3 mm and" in codes[0]
    assert "give these values [mm, deg]" in codes[0]
    np.testing.assert_allclose(place, [70.0, 0.0, 0.0], atol=1e-3)
    assert codes[1] is None


def test_a_body_that_is_turned_by_a_right_angle(tmp_path):
    off = {"rocker": ([1.0, 0.5, 0.0], [0.0, 0.0, 180.0])}
    found = judged(tmp_path, four_bar(**off), t_end=0.01).finding("start-moved")
    angles = [float(x) for x in re.findall(r"and ([0-9.e-]+) deg", found["message"])]
    assert sum(sorted(angles)[-2:]) == pytest.approx(90.0, abs=0.1)


@pytest.mark.parametrize(
    "text",
    [
        four_bar(0.0009),
        four_bar(drive="drive = { polynomial = [0.5, 1.0] }"),
        rigid("slider", 1.0, 0.1, {"pin": (0, 0, 0)}, position=[0.7, 1e-4, 0.0])
        + '[ground.o]\nposition = [0.0, 0.0, 0.0]\n[joints.rail]\nkind = "prismatic"\n'
        + 'between = ["ground.o", "slider.pin"]\naxis = [1.0, 0.0, 0.0]\n'
        + "drive = { polynomial = [0.2, 1.0] }\n",
        rigid("bob", 1.0, 0.1, {"pin": (-1, 0, 0)})
        + '[ground.o]\nposition = [0.3, 0.0, 0.0]\n[joints.pin]\nkind = "revolute"\n'
        + 'between = ["ground.o", "bob.pin"]\n',
    ],
    ids=["small", "driven", "a driven slider", "placed by the program"],
)
def test_starts_that_are_as_asked(tmp_path, text):
    _, _, summary = run_text(tmp_path, text, t_end=0.01, step=0.01)
    assert "start-moved" not in {w["code"] for w in summary["warnings"]}


@pytest.mark.parametrize("case", ["bricard", "slider-crank", "spinning-plate", "n-four-bar"])
def test_shipped_cases_start_where_they_say(repository, tmp_path, case):
    for file in sorted(case_runs(repository, case, tmp_path).glob("*.json")):
        spec = read_run(file)
        ready = prepare(spec.mechanism, spec.packages)
        assert "start-moved" not in {finding.code for finding in ready.notes}, file


@pytest.mark.parametrize("law", ["[0.0, 1.0]", "[0.5, 1.0]"])
def test_places_to_give_beside_a_drive_do_not_change_the_motion(tmp_path, law):
    """The drive keeps the crank where it is given: its angle counts from there."""
    drive = f"drive = {{ polynomial = {law} }}"
    signals = "".join(
        f'[signals.{c}]\nkind = "position"\nat = "rocker.b"\ncomponent = "{c}"\n' for c in "xy"
    )
    _, first, summary = run_text(tmp_path, four_bar(0.034, drive) + signals, t_end=0.1, step=0.1)
    (moved,) = [w["message"] for w in summary["warnings"] if w["code"] == "start-moved"]
    given = places_to_give(moved)
    assert set(given) == {"rocker"}  # the coupler moves by less than the limit
    text = four_bar(0.034, drive, **given) + signals
    _, second, summary = run_text(tmp_path, text, t_end=0.1, step=0.1)
    assert "start-moved" not in {w["code"] for w in summary["warnings"]}
    for c in "xy":
        np.testing.assert_allclose(second[c], first[c], atol=1e-7)


def test_no_places_are_given_where_the_drive_cannot_start(tmp_path):
    """The loop does not close with the crank where it is given, only where its law begins."""
    text = four_bar(1.5, "drive = { polynomial = [-1.2, 0.1] }")
    _, _, summary = run_text(tmp_path, text, t_end=0.01, step=0.01)
    (moved,) = [w["message"] for w in summary["warnings"] if w["code"] == "start-moved"]
    assert "rocker by " in moved
    assert not places_to_give(moved)
