"""Lay-ups as text, by the notation of laminates: [±45/0_2]2s."""

import pytest
from pydantic import ValidationError

from plymotion.solver.inputs.common.layup import angles_of
from plymotion.solver.inputs.common.materials import Laminate
from plymotion.solver.inputs.shell import ShellLaminate


@pytest.mark.parametrize(
    ("text", "angles"),
    [
        ("[0/45/-45/90]s", [0, 45, -45, 90, 90, -45, 45, 0]),
        ("[±45/0_2]s", [45, -45, 0, 0, 0, 0, -45, 45]),
        ("[+/-45, 0]", [45, -45, 0]),
        ("[∓30_2]T", [-30, 30, -30, 30]),
        ("[0/90]2s", [0, 90, 0, 90, 90, 0, 90, 0]),
        ("[0/90]_{2}_s", [0, 90, 0, 90, 90, 0, 90, 0]),
        ("[(0/90)_3/45]", [0, 90, 0, 90, 0, 90, 45]),
        ("[[0/90]s/30]", [0, 90, 90, 0, 30]),
        ("[0₂/90°]ₛ", [0, 0, 90, 90, 0, 0]),
        (" [ 0 / ± 22.5 ] s ", [0, 22.5, -22.5, -22.5, 22.5, 0]),
    ],
)
def test_the_notation_is_read(text: str, angles: list[float]) -> None:
    assert angles_of(text) == angles
    laminate = ShellLaminate(material="cfrp", layup=text, ply_thickness=1e-4)
    assert [ply["angle_deg"] for ply in laminate.stack()] == angles


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0/90", r"expected brackets, such as \[0/45"),
        ("[0/91]", "91: expected an angle from -90 to 90"),
        ("[0/90", r'expected / or \], found ""'),
        ("[0//90]", 'expected an angle, found "/90]"'),
        ("[0 90]", r'expected / or \], found " 90\]"'),
        ("[0/90]x", 'expected a number, s or T after the last bracket, found "x"'),
        ("[(0/90]", r'expected / or \), found "\]"'),
        ("[0]100000", "expected up to 10000"),
        ("[" * 501, "500 characters"),
    ],
)
def test_what_cannot_be_read_is_named(text: str, message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        Laminate(material="cfrp", layup=text)


def test_a_lay_up_says_all() -> None:
    for more in ({"symmetric": True}, {"repeat": 2}):
        with pytest.raises(ValidationError, match="neither `repeat` nor `symmetric`"):
            Laminate(material="cfrp", layup="[0/90]", **more)
    with pytest.raises(ValidationError, match="either `angles_deg` or `layup`"):
        Laminate(material="cfrp", layup="[0/90]", angles_deg=[0])
