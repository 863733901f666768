"""Body specifications: what the preprocessor takes over, and what it says of a broken file."""

from typing import Any

import numpy as np
import pytest
from samples.body_specs import beam_body

from plymotion.preprocess.beam.beam_body import beam_model
from plymotion.preprocess.beam.beam_specification import ModeSpec, Reference, read_spec
from plymotion.preprocess.beam.line import LineSection
from plymotion.preprocess.modes.eigenmodes import ModeRequest
from plymotion.solver.package.common.plain_data import SpecError
from plymotion.solver.package.specification import fingerprint


def spec(**changes: Any) -> dict[str, Any]:
    entries = {
        "body": "arm",
        "length": 0.545,
        "elements": 16,
        "section": {"shape": "rectangle"},
        "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}, "mid": {"at": 0.5}},
        "modes": [{"kind": "bending-xy", "count": 4}],
        **changes,
    }
    return beam_body(**entries)


def test_places_and_axes_become_numbers() -> None:
    beam = read_spec(spec())
    assert beam.reference == Reference("clamped", (("root", 0.0),))
    assert beam.modes == ModeSpec((ModeRequest("bending-xy", 4),))
    assert np.array_equal(beam.A_BE, np.eye(3))
    assert beam.interfaces == {"root": 0.0, "tip": 1.0, "mid": 0.5}


def test_reference_conditions_and_static_modes() -> None:
    chord = read_spec(spec(reference={"kind": "chord", "at": ["mid", "tip"]})).reference
    assert chord == Reference("chord", (("mid", 0.5), ("tip", 1.0)))
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
    model = beam_model(read_spec(asked), LineSection(np.eye(6), np.eye(6)))
    assert model.reference_nodes == (0, 16)
    assert model.loaded_nodes == (0, 8, 16)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"lenght": 1.0}, "^lenght: unknown key; did you mean 'length'"),
        ({"length": float("nan")}, "^length: expected a number, found nan"),
        ({"length": "long"}, "^length: expected a number, found 'long'"),
        ({"length": True}, "^length: expected a number, found True"),
        ({"elements": 16.0}, "^elements: expected a whole number, found 16.0"),
        ({"elements": True}, "^elements: expected a whole number, found True"),
        ({"kind": "shell"}, "^kind: expected one of beam, found 'shell'"),
        ({"body": None}, "^body: expected a text, found None"),
        ({"section": "strip"}, "^section: expected an object, found 'strip'"),
        ({"x2_axis": [0.0, "y", 0.0]}, r"^x2_axis\[1\]: expected a number, found 'y'"),
        ({"mass_form": "lumpd"}, "^mass_form: .*; did you mean 'lumped'"),
        (
            {"modes": [{"kind": "bending-yx", "count": 1}]},
            r"^modes\[0\].kind: expected one of lowest.*did you mean 'bending",
        ),
        ({"modes": [{"kind": "axial"}]}, r"^modes\[0\].count: missing; expected a whole number"),
        ({"interfaces": {"tip": {"at": "top"}}}, "^interfaces.tip.at: expected one of start, end"),
        ({"interfaces": {"tip": {"on": 1}}}, r"^interfaces.tip.on: unknown key.* \(known: at\)"),
        ({"interfaces": {"tip": "end"}}, "^interfaces.tip: expected an object with at"),
        (
            {"reference": {"kind": "chrod"}},
            "^reference.kind: expected one of .*did you mean 'chord'",
        ),
        (
            {"reference": {"kind": "chord", "at": ["root", "top"]}},
            "^reference.at: expected one of the interfaces root, tip, mid, found 'top'",
        ),
        ({"reference": {"kind": "clamped", "at": 0}}, "^reference.at: expected a text or a list"),
        (
            {"modes": [{"kind": "attachment", "at": "rot"}]},
            r"^modes\[0\].at: .*; did you mean 'root'",
        ),
        (
            {"modes": [{"kind": "attachment", "at": "mid", "directions": ["u"]}]},
            r"^modes\[0\].directions\[0\]: expected one of x, y, z, rx, ry, rz, found 'u'",
        ),
        ({"modes": [{"kind": "static-axial", "count": 1}]}, r"^modes\[0\].count: unknown key"),
    ],
)
def test_message_names_key_value_and_expectation(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SpecError, match=message):
        read_spec(spec(**changes))


def test_lists_are_lists() -> None:
    with pytest.raises(SpecError, match=r"^modes: expected a list, found 4"):
        read_spec(spec() | {"modes": 4})
    with pytest.raises(SpecError, match=r"^specification: expected an object with inputs_sha256"):
        read_spec([])  # type: ignore[arg-type]


def test_nothing_is_left_to_the_reader() -> None:
    """Every key is there: the case has filled in the defaults."""
    for key in spec():
        incomplete = spec()
        del incomplete[key]
        with pytest.raises(SpecError, match=f"^{key}: missing; expected"):
            read_spec(incomplete)


def test_interfaces_get_nodes_and_need_enough_elements() -> None:
    odd = {"root": {"at": "start"}, "a": {"at": 0.3}, "tip": {"at": "end"}}
    model = beam_model(read_spec(spec(interfaces=odd)), LineSection(np.eye(6), np.eye(6)))
    assert model.line.along[model.node_of["a"]] == pytest.approx(0.3 * 0.545, rel=1e-14)
    with pytest.raises(SpecError, match=r"elements: expected at least 2.*found 1"):
        beam_model(read_spec(spec(interfaces=odd, elements=1)), LineSection(np.eye(6), np.eye(6)))


def test_fingerprint_changes_with_the_body_only() -> None:
    base = fingerprint(spec())
    assert fingerprint(spec(inputs_sha256="abc", case="double-pendulum")) == base
    assert fingerprint(dict(reversed(spec().items()))) == base
    assert fingerprint(spec(elements=17)) != base
    assert fingerprint(spec(section={"shape": "rectangle", "width": 0.1})) != base
