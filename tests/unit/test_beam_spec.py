"""Body specifications: what is accepted, and what the messages say."""

from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.beam.body import beam_model
from plymotion.preprocess.beam.spec import SpecError, read_spec
from plymotion.preprocess.beam.spec_modes import ModeSpec, Reference
from plymotion.preprocess.fingerprint import fingerprint
from plymotion.preprocess.modes import ModeRequest


def spec(**changes: Any) -> dict[str, Any]:
    return {
        "body": "arm",
        "kind": "beam",
        "length": 0.545,
        "elements": 16,
        "section": {"shape": "rectangle"},
        "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}, "mid": {"at": 0.5}},
        "modes": [{"kind": "bending-xy", "count": 4}],
        **changes,
    }


def test_defaults() -> None:
    beam = read_spec(spec())
    assert beam.mass_form == "consistent"
    assert beam.reference == Reference("clamped", (("start", 0.0),))
    assert beam.modes == ModeSpec((ModeRequest("bending-xy", 4),))
    assert np.array_equal(beam.A_BE, np.eye(3))
    assert beam.interfaces == {"root": 0.0, "tip": 1.0, "mid": 0.5}


def test_one_request_may_stand_without_list_and_kind() -> None:
    assert read_spec(spec(modes={"count": 4})).modes == ModeSpec((ModeRequest("lowest", 4),))


def test_reference_conditions_and_static_modes() -> None:
    chord = read_spec(spec(reference={"kind": "chord", "at": ["mid", "end"]})).reference
    assert chord == Reference("chord", (("mid", 0.5), ("end", 1.0)))
    assert read_spec(spec(reference={"kind": "mean-axis"})).reference == Reference("mean-axis", ())
    modes = [
        {"kind": "attachment", "at": "mid", "directions": ["y", "rz"]},
        {"kind": "static-axial"},
        {"kind": "attachment", "at": "tip"},
    ]
    found = read_spec(spec(modes=modes)).modes
    six = tuple(("tip", direction) for direction in ("x", "y", "z", "rx", "ry", "rz"))
    assert found == ModeSpec((), (("mid", "y"), ("mid", "rz"), *six), True)


def test_frame_and_attachments_get_nodes() -> None:
    asked = spec(
        reference={"kind": "chord", "at": ["root", "tip"]},
        modes=[{"kind": "attachment", "at": "mid", "directions": ["y"]}],
    )
    model = beam_model(read_spec(asked), np.eye(6), np.eye(6))
    assert model.reference_nodes == (0, 16)
    assert model.loaded_nodes == (0, 8, 16)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"lenght": 1.0}, "lenght: unknown key; did you mean 'length'"),
        ({"length": -1.0}, r"length: expected a number above 0 \[m\], found -1.0"),
        ({"length": float("nan")}, "length: expected a number"),
        ({"length": "long"}, "length: expected a number"),
        ({"elements": 0}, "elements: expected a whole number of at least 1, found 0"),
        ({"elements": True}, "elements: expected a whole number"),
        ({"kind": "shell"}, "kind: expected 'beam', found 'shell'"),
        ({"body": ""}, "body: expected a name"),
        ({"section": "strip"}, "section: expected an object"),
        ({"x2_axis": [1, 0, 0]}, "x2_axis: expected a unit vector"),
        ({"mass_form": "lumpd"}, "mass_form: .*; did you mean 'lumped'"),
        ({"damping_ratio": -0.1}, "damping_ratio: expected a number of at least 0"),
        (
            {"modes": [{"kind": "bending-yx", "count": 1}]},
            r"modes\[0\].kind: .*; did you mean 'bending",
        ),
        ({"modes": [{"kind": "axial"}]}, r"modes\[0\].count: expected a whole number"),
        ({"modes": 4}, "modes: expected a list"),
        ({"interfaces": {}}, "interfaces: expected names"),
        ({"interfaces": {"tip": {"at": 1.5}}}, "interfaces.tip.at: .* at most 1, found 1.5"),
        ({"interfaces": {"tip": {"at": "top"}}}, "interfaces.tip.at: expected 'start'"),
        ({"interfaces": {"tip": {"on": 1}}}, "interfaces.tip: expected"),
        (
            {"reference": {"kind": "chrod"}},
            "reference.kind: expected one of .*did you mean 'chord'",
        ),
        ({"reference": {"kind": "chord"}}, "reference.at: expected two places"),
        ({"reference": {"kind": "chord", "at": ["root", "top"]}}, "reference.at: expected one of"),
        (
            {"reference": {"kind": "chord", "at": ["root", "start"]}},
            "reference.at: expected two different places",
        ),
        ({"reference": {"kind": "mean-axis", "at": "root"}}, "reference.at: expected no such key"),
        (
            {"modes": [{"kind": "attachment", "at": "rot"}]},
            r"modes\[0\].at: .*; did you mean 'root'",
        ),
        (
            {"modes": [{"kind": "attachment", "at": "mid", "directions": ["u"]}]},
            r"modes\[0\].directions: expected one of x, y, z, rx, ry, rz, found 'u'",
        ),
        (
            {"modes": [{"kind": "attachment", "at": "mid", "directions": []}]},
            r"modes\[0\].directions: expected a list",
        ),
        ({"modes": [{"kind": "static-axial", "count": 1}]}, r"modes\[0\].count: unknown key"),
        ({"reference": {"at": "rot"}}, "reference.at: .*; did you mean 'root'"),
    ],
)
def test_message_names_key_value_and_expectation(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SpecError, match=message):
        read_spec(spec(**changes))


def test_missing_key() -> None:
    incomplete = spec()
    del incomplete["elements"]
    with pytest.raises(SpecError, match="elements: missing"):
        read_spec(incomplete)


def test_interfaces_get_nodes_and_need_enough_elements() -> None:
    odd = {"root": {"at": "start"}, "a": {"at": 0.3}, "tip": {"at": "end"}}
    model = beam_model(read_spec(spec(interfaces=odd)), np.eye(6), np.eye(6))
    assert model.line.x_B[model.node_of["a"]] == pytest.approx(0.3 * 0.545, rel=1e-14)
    with pytest.raises(SpecError, match=r"elements: expected at least 2.*found 1"):
        beam_model(read_spec(spec(interfaces=odd, elements=1)), np.eye(6), np.eye(6))


def test_fingerprint_changes_with_the_body_only() -> None:
    base = fingerprint(spec())
    assert fingerprint(spec(inputs_sha256="abc", case="double-pendulum")) == base
    assert fingerprint(dict(reversed(spec().items()))) == base
    assert fingerprint(spec(elements=17)) != base
    assert fingerprint(spec(section={"shape": "rectangle", "width": 0.1})) != base
