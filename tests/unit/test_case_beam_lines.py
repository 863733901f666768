"""Keys of curved, twisted and tapered beams: messages, and what they become in a specification."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from samples.curved_samples import BAR

from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.solver.inputs.case.bodies.specifications import BodySpecs
from plymotion.solver.inputs.case.checks import in_parts
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.package.common.plain_data import SpecError

MODES = [{"kind": "lowest", "count": 2}]
NODES = {"nodes": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], "x2_axes": [[0.0, 1.0, 0.0]]}


def checked(**keys: Any) -> tuple[Any, list[str]]:
    """The specification of a beam with these keys, and what is wrong."""
    body = {"length": 1.0, "elements": 4, "modes": MODES, **BAR, **keys}
    body = {key: value for key, value in body.items() if value is not None}
    material = {"kind": "isotropic", "E": 1.0, "nu": 0.0, "rho": 1.0}
    sections = {
        name: {"shape": "rectangle", "width": width, "height": 0.01}
        for name, width in (("s", 0.1), ("slim", 0.05))
    }
    table = {
        "materials": {"m": material},
        "sections": sections,
        "bodies": {"bar": body},
        "solver": {"t_end": 1.0, "output_step": 0.1},
    }
    _, specs, problems = in_parts(Mechanism.model_validate(table), BodySpecs(Path()))
    return (specs["bar"].content if not problems else None), problems


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"line": {"arc_deg": 0.0}}, "bodies.bar.line.arc_deg = 0: expected an angle"),
        ({"line": {"arc_deg": 9.0, "axis": [1.0, 0.0, 0.0]}}, "line.axis = .*normal to body x"),
        ({"line": {"arc_deg": 9.0}, "length": None}, "bodies.bar.length: missing"),
        ({"length": None}, "bodies.bar.length: missing"),
        ({"line": NODES}, "bodies.bar.length = 1: expected none, the line has a length"),
        (
            {"line": {**NODES, "x2_axes": 2 * NODES["x2_axes"]}, "length": None},
            "bodies.bar.line.x2_axes: 2 axes; expected one for each of 1 elements",
        ),
        ({"line": NODES, "length": None, "twist_deg": [[1.0, 5.0]]}, "the nodes have axes"),
        (
            {"line": {"points": [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}, "length": None},
            "bodies.bar.line: two neighbouring points are the same",
        ),
        ({"twist_deg": [[1.0, 3.0], [0.5, 2.0]]}, r"twist_deg: expected rising .* found \[1.0"),
        (
            {"stations": [{"at": 1.0, "section": "slom"}]},
            r'bodies.bar.stations\.0.section = "slom": no such section; did you mean .slim',
        ),
        (
            {"stations": [{"at": 0.9, "section": "slim"}, {"at": 0.5, "section": "slim"}]},
            r"bodies.bar.stations: at = \[0.9, 0.5\]: expected rising",
        ),
        (
            {"stations": [{"at": 0.5, "section": "slim"}], "elements": 1},
            "elements = 1: expected at least 2: every interface and station needs a node",
        ),
        (
            {"line": {"arc_deg": 9.0}, "modes": [{"kind": "spinning-xy", "count": 2}]},
            'kind = "spinning-xy": expected a straight beam',
        ),
        (
            {
                "line": {"arc_deg": 90.0},
                "interfaces": {"a": {"at": "start"}, "b": {"at": "end"}},
                "reference": {"kind": "chord", "at": ["a", "b"]},
            },
            "bodies.bar.reference.at: interface b is at .*expected a place on body x",
        ),
    ],
)
def test_message_names_key_and_expectation(keys: dict[str, Any], message: str) -> None:
    _, problems = checked(**keys)
    with pytest.raises(AssertionError, match=message):
        raise AssertionError("\n".join(problems))


@pytest.mark.parametrize("line", [{}, {"arc_deg": 9.0, **NODES}, {"nodes": NODES["nodes"]}])
def test_a_line_is_one_of_three(line: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match=r"expected (one of arc_deg|nodes and x2_axes)"):
        checked(line=line, length=None)


def test_stations_become_sections_of_the_specification() -> None:
    spec, _ = checked(stations=[{"at": 0.5, "section": "slim"}, {"at": 1.0, "section": "s"}])
    assert [station["at"] for station in spec["stations"]] == [0.0, 0.5, 1.0]
    names = [station["section"]["name"] for station in spec["stations"]]
    assert names == ["s", "slim", "s"]
    assert spec["section"] == spec["stations"][0]["section"]
    assert read_spec(dict(spec)).stations == (0.0, 0.5, 1.0)
    plain, _ = checked()
    assert not {"stations", "line"} & set(plain)


def test_line_becomes_nodes_and_axes() -> None:
    spec, _ = checked(
        line={"arc_deg": 90.0}, interfaces={"root": {"at": "start"}, "a": {"at": 0.3}}
    )
    beam = read_spec(dict(spec))
    radius = 1.0 / (np.pi / 2)
    assert spec["elements"] == 4
    np.testing.assert_allclose(np.linalg.norm(beam.nodes_B - [0.0, radius, 0.0], axis=1), radius)
    at = np.radians(27.0)
    expected = radius * np.array([np.sin(at), 1.0 - np.cos(at), 0.0])
    assert np.linalg.norm(beam.nodes_B - expected, axis=1).min() < 1e-11
    for A in beam.A_BE:
        np.testing.assert_allclose(A.T @ A, np.eye(3), atol=1e-14)
        assert np.linalg.det(A) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ({"nodes": [[0.0, 0.0, 0.0]], "x2_axes": []}, "one x2 axis less than nodes"),
        ({**NODES, "nodes": [[0.0, 0.0], [1.0, 0.0]]}, "rows of three numbers"),
        ({**NODES, "nodes": [[0.0, 0.0, 0.0]] * 2}, "two neighbours have the same position"),
        ({**NODES, "x2_axes": [[1.0, 0.0, 0.0]]}, "an axis is along its element"),
    ],
)
def test_preprocessor_refuses_a_broken_line(line: dict[str, Any], message: str) -> None:
    spec, _ = checked()
    with pytest.raises(SpecError, match=message):
        read_spec({**spec, "line": line})


def test_preprocessor_refuses_falling_stations() -> None:
    spec, _ = checked()
    stations = [{"at": 1.0, "section": {}}, {"at": 0.0, "section": {}}]
    with pytest.raises(SpecError, match=r"stations: expected rising fractions"):
        read_spec({**spec, "stations": stations})
