"""Coordinates of joints at the start: bodies are moved so that the mechanism closes with them."""

import numpy as np
import pytest
from samples.case_samples import rigid, run_text

from plymotion.solver.errors import InputError

ENDS = {"a": (-0.5, 0, 0), "b": (0.5, 0, 0)}
LINK = {"root": (-0.5, 0, 0), "tip": (0.5, 0, 0)}


def signal(name: str, text: str) -> str:
    return f"[signals.{name}]\n{text}\n"


def chain(first: float, second: float) -> str:
    """Two links of 1 m along x on the ground, with angles at their hinges [deg]."""
    text = rigid("one", 1.0, 0.1, LINK, position=(0.5, 0, 0))
    text += (
        rigid("two", 1.0, 0.1, LINK, position=(1.5, 0, 0)) + "[ground.o]\nposition = [0, 0, 0]\n"
    )
    text = text.replace("[0, 0, 0]", "[0.0, 0.0, 0.0]")
    for name, between, angle in (
        ("shoulder", ("ground.o", "one.root"), first),
        ("elbow", ("one.tip", "two.root"), second),
    ):
        text += f'[joints.{name}]\nkind = "revolute"\nbetween = {list(between)}\n'
        text += f"start_deg = {angle}\n"
        text += signal(name, f'kind = "joint"\njoint = "{name}"')
    for axis in "xy":
        text += signal(axis, f'kind = "position"\nat = "two.tip"\ncomponent = "{axis}"')
    return text


@pytest.mark.parametrize("attachment", ["marker", "virtual"])
@pytest.mark.parametrize(("first", "second"), [(30.0, 45.0), (-170.0, 120.0), (0.0, 90.0)])
def test_an_open_chain_starts_at_its_angles(tmp_path, first, second, attachment):
    more = f'attachment = "{attachment}"'
    _, values, summary = run_text(tmp_path, chain(first, second), t_end=0.01, step=0.01, more=more)
    a, b = np.radians(first), np.radians(first + second)
    assert values["shoulder"][0] == pytest.approx(a, abs=1e-9)
    assert values["elbow"][0] == pytest.approx(np.radians(second), abs=1e-9)
    assert values["x"][0] == pytest.approx(np.cos(a) + np.cos(b), abs=1e-9)
    assert values["y"][0] == pytest.approx(np.sin(a) + np.sin(b), abs=1e-9)
    assert "start-moved" not in {w["code"] for w in summary["warnings"]}


def four_bar(crank: str) -> str:
    """A parallelogram of 1 m, whose crank has a key at the start."""
    places = {"crank": ((0, 0.5, 0), 90), "coupler": ((0.5, 1, 0), 0), "rocker": ((1, 0.5, 0), 90)}
    text = "".join(
        rigid(name, 1.0, 0.1, ENDS, position=at, rotation_deg=(0, 0, turn))
        for name, (at, turn) in places.items()
    )
    text += "[ground.o]\nposition = [0.0, 0.0, 0.0]\n[ground.p]\nposition = [1.0, 0.0, 0.0]\n"
    hinges = [
        ("ground.o", "crank.a"),
        ("crank.b", "coupler.a"),
        ("coupler.b", "rocker.b"),
        ("ground.p", "rocker.a"),
    ]
    for k, between in enumerate(hinges):
        text += f'[joints.j{k}]\nkind = "revolute"\nbetween = {list(between)}\n'
        text += crank if k == 0 else ""
        text += signal(f"q{k}", f'kind = "joint"\njoint = "j{k}"')
    return text


def test_a_closed_loop_is_assembled_at_the_angle_of_its_crank(tmp_path):
    """Opposite links of a parallelogram stay parallel."""
    text = four_bar("start_deg = -60.0\n")
    _, values, summary = run_text(tmp_path, text, t_end=0.01, step=0.01)
    turn = np.radians(-60.0)
    found = [values[f"q{k}"][0] for k in range(4)]
    np.testing.assert_allclose(found, [turn, -turn, turn, turn], atol=1e-7)
    assert "start-moved" not in {w["code"] for w in summary["warnings"]}


def test_a_slider_starts_at_its_displacement(tmp_path):
    text = rigid("block", 1.0, 0.1, {"c": (0, 0, 0)}) + "[ground.o]\nposition = [0.0, 0.0, 0.0]\n"
    text += '[joints.rail]\nkind = "cylindrical"\nbetween = ["ground.o", "block.c"]\n'
    text += "start = 0.2\nstart_deg = 50.0\n"
    text += signal("z", 'kind = "joint"\njoint = "rail"\ncoordinate = "z"')
    text += signal("turn", 'kind = "joint"\njoint = "rail"\ncoordinate = "angle"')
    _, values, _ = run_text(tmp_path, text, t_end=0.01, step=0.01)
    assert values["z"][0] == pytest.approx(0.2, abs=1e-9)
    assert values["turn"][0] == pytest.approx(np.radians(50.0), abs=1e-9)


@pytest.mark.parametrize(
    ("crank", "message"),
    [
        ("start = 0.1\n", "joints.j0.start: unknown key"),
        ("start_deg = 10.0\ndrive = { speed = 1.0 }\n", "j0.drive: expected no drive of a coord"),
    ],
)
def test_a_start_that_cannot_be_is_refused(tmp_path, crank, message):
    with pytest.raises(InputError, match=message):
        run_text(tmp_path, four_bar(crank), t_end=0.01, step=0.01)


def test_angles_that_do_not_close_name_the_joints(tmp_path):
    text = four_bar("start_deg = -60.0\n")
    text = text.replace("['coupler.b', 'rocker.b']", "['coupler.b', 'rocker.b']\nstart_deg = 5.0")
    with pytest.raises(InputError, match="cannot be assembled"):
        run_text(tmp_path, text, t_end=0.01, step=0.01)
