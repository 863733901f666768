"""A flyball governor with springs at its sleeve, damped and not: few refusals, no false hints."""

import pytest
from samples.case_samples import HEAD, computed_file, rigid

SLEEVE, ARM, REST = 0.5, 0.8, 0.2836  # [m] below the hinge, of the arms, of the springs unloaded


def governor(folder, stiffness: float, damping: float):
    """Two arms of 5 kg at 30 degrees to a shaft that spins at 2 pi rad/s, without drive."""
    text = "gravity = [0.0, 0.0, -9.81]\n[ground]\nO = { position = [0.0, 0.0, 0.0] }\n"
    points = {"top": [0, 0, 0], "low": [0, 0, -SLEEVE]}
    text += rigid("shaft", 0.3, [0.01, 0.01, 0.005], points, angular_velocity=[0, 0, 6.283185])
    text += rigid("sleeve", 1.0, [0.15, 0.125, 0.14], {"c": [0, 0, 0]}, position=[0, 0, -SLEEVE])
    for name, side in (("left", 1), ("right", -1)):
        points = {"top": [0, 0, ARM], "mid": [0, 0, 0.5]}
        place = {"position": [side * 0.4, 0, -0.69282], "rotation_deg": [0, -side * 30.0, 0]}
        text += rigid(name, 5.0, [0.4, 0.4, 0.02], points, **place)
        text += f"""
[joints.{name}]
kind = "revolute"
between = ["shaft.top", "{name}.top"]
axis = [0.0, 1.0, 0.0]
[forces.{name}]
kind = "spring"
between = ["sleeve.c", "{name}.mid"]
stiffness = {stiffness}
damping = {damping}
length = {REST}
"""
    text += """
[joints.shaft]
kind = "revolute"
between = ["ground.O", "shaft.top"]
axis = [0.0, 0.0, 1.0]
[joints.sleeve]
kind = "prismatic"
between = ["shaft.low", "sleeve.c"]
axis = [0.0, 0.0, 1.0]
[solver]
t_end = 10.0
output_step = 0.01
[runs.base]
"""
    return computed_file(folder / "case.toml", HEAD + text)[1]


@pytest.mark.parametrize(
    ("stiffness", "damping", "codes"),
    [(8e5, 4e4, []), (8e5, 0.0, []), (8e7, 0.0, ["vibration-damped"])],
)
def test_a_governor_takes_few_refusals(tmp_path, stiffness, damping, codes):
    summary = governor(tmp_path, stiffness, damping)
    cost = summary["cost"]
    assert summary["completed"]
    assert cost["rejected"] < 0.2 * (cost["steps"] + cost["rejected"])
    assert summary["hints"] == []
    assert [warning["code"] for warning in summary["warnings"]] == codes
    if codes:
        assert summary["warnings"][0]["body"] == "sleeve"
        assert cost["steps"] < 10_000  # 50,000 a second without a cutoff
