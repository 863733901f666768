"""Plans that a user has edited: what is wrong is told by file, key, value and expectation."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plymotion.solver.errors import InputError
from plymotion.solver.run.inputs import plan_sha256
from plymotion.solver.studies.fidelity.choice import kept_plan, plan_of_table, read_plan, write_plan
from plymotion.solver.studies.fidelity.plan import BodyPlan, Plan

KNOWN = {"link": {"model": ("bending-xy 1", "torsion 1"), "check": ("bending-xy 1",)}}
PLAN = Plan({"link": BodyPlan(("bending-xy 1",), 2, True)}, True, 1e-4, "digest")
TOML = """format = 1
inputs_sha256 = "digest"
rtol = 0.0001
geometric_stiffening = true

[bodies.link]
vibrations = ["bending-xy 1"]
static_shapes = 2
ringing = true
mesh = "model"
"""


@pytest.fixture
def file(tmp_path):
    return tmp_path / "base.toml"


def refusal(file, content):
    """Message of a plan with this content (text or bytes)."""
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError) as error:
        kept_plan(file, KNOWN, "digest")
    text = str(error.value)
    assert text.startswith(f"{file}: ")
    assert all(len(line) < len(str(file)) + 300 for line in text.splitlines())
    return text.removeprefix(f"{file}: ")


def test_a_plan_is_read_as_it_was_written(file):
    write_plan(file, PLAN, ["a remark"])
    assert read_plan(file, KNOWN) == PLAN
    assert file.read_text() == "# a remark\n" + TOML
    assert kept_plan(file, KNOWN, "digest") == PLAN
    whole = PLAN.with_body("link", whole=True)
    write_plan(file, whole, [])
    assert read_plan(file, KNOWN) == whole


def test_a_plan_of_rigid_bodies_has_no_bodies(file):
    for rtol in (1e-4, 2.0e-3 / 3.0):
        write_plan(file, Plan({}, False, rtol), [])
        assert read_plan(file, {}) == Plan({}, False, rtol)


def test_a_plan_of_other_inputs_is_not_looked_at(file):
    """Its bodies may be gone: a case that was changed needs a new plan, not a correct old one."""
    assert kept_plan(file, KNOWN, "digest") is None
    write_plan(file, PLAN, [])
    assert kept_plan(file, {"arm": KNOWN["link"]}, "other") is None


def test_a_plan_that_is_replaced_by_another_is_kept(file):
    previous = file.with_suffix(".previous.toml")
    write_plan(file, PLAN, [])
    write_plan(file, replace(PLAN, inputs_sha256="new"), ["the same plan for other inputs"])
    assert not previous.exists()
    edited = TOML.replace("static_shapes = 2", "static_shapes = 3")
    file.write_text(edited)
    write_plan(file, PLAN, [])
    assert previous.read_text() == edited


def test_digest_of_a_plan_is_that_of_what_it_says(file):
    file.write_text(TOML)
    said = plan_sha256(file)
    file.write_text("# note\n" + TOML.replace("digest", "other").replace("0.0001", "1e-4"))
    assert plan_sha256(file) == said
    file.write_text(TOML.replace("0.0001", "1e-5"))
    assert plan_sha256(file) not in ("", said)
    file.write_text("rtol =")
    assert plan_sha256(file) == ""
    file.unlink()
    assert plan_sha256(file) == ""


LINES = {
    "format": [
        ("format = 2", "format = 2: value should be less than or equal to 1"),
        ('format = "1"', 'format = "1": value should be a valid integer'),
        ("format = true", "format = True: value should be a valid integer"),
        ("", "format: missing; expected a value: version of the format"),
    ],
    "inputs_sha256": [
        ("", "inputs_sha256: missing; expected a value: digest"),
        ("inputs_sha256 = 5", "inputs_sha256 = 5: expected a text in quotes"),
    ],
    "rtol": [
        ("rtol = nan", "rtol = nan: value should be a finite number"),
        ("rtol = -nan", "rtol = nan: value should be a finite number"),
        ("rtol = inf", "rtol = inf: value should be a finite number"),
        ("rtol = -1e-4", "rtol = -0.0001: value should be greater than or equal to 1e-15"),
        ("rtol = 0", "rtol = 0: value should be greater than or equal to 1e-15"),
        ("rtol = 1e-300", "rtol = 1e-300: value should be greater"),
        ("rtol = 0.2", "rtol = 0.2: value should be less than or equal to 0.1"),
        (f"rtol = {10**300}", "...: value should be less than or equal to 0.1"),
        (
            f"rtol = 0x{'f' * 5000}",
            "rtol = a number of thousands of digits: value should",
        ),
        (f"rtol = {'9' * 5000}", "not valid TOML"),
        ('rtol = "1e-4"', 'rtol = "1e-4": value should be a valid number, without quotes'),
        (f'rtol = "{"x" * 5000}"', f'rtol = "{"x" * 50}'),
        ("rtol = true", "rtol = True: value should be a valid number"),
        ("rtol = [1e-4]", "rtol = [0.0001]: value should be a valid number"),
        ("rtol = 1979-05-27", "rtol = datetime.date(1979, 5, 27): value should be a valid number"),
        ("rtoll = 1e-4", "rtoll: unknown key; did you mean 'rtol'?"),
        ("rtol = 1e-4\nrtol = 1e-5", "not valid TOML"),
        ("rtol = ", "not valid TOML"),
    ],
    "geometric_stiffening": [
        ("geometric_stiffening = 1", "geometric_stiffening = 1: expected true or false"),
        ("geometric_stiffening = {}", "geometric_stiffening = {}: expected true or false"),
    ],
    "vibrations": [
        ('vibrations = "bending-xy 1"', 'bodies.link.vibrations = "bending-xy 1": expected a list'),
        ("vibrations = [1]", "bodies.link.vibrations.0 = 1: value should be a valid string"),
        (
            'vibrations = [["bending-xy 1"]]',
            "vibrations.0 = ['bending-xy 1']: value should be",
        ),
        ('vibrations = ["bending-xz 1"]', "did you mean 'bending-xy 1'?"),
        ('vibrations = ["torsion 1", "torsion 1"]', '"torsion 1": twice; expected it once'),
        ("vibrations = [nan]", "bodies.link.vibrations.0 = nan: value should be a valid string"),
    ],
    "static_shapes": [
        (
            "static_shapes = -1",
            "static_shapes = -1: value should be greater than or equal to 0",
        ),
        (
            "static_shapes = 21",
            "static_shapes = 21: value should be less than or equal to 20",
        ),
        ("static_shapes = 1.0", "bodies.link.static_shapes = 1.0: value should be a valid integer"),
        (
            f"static_shapes = {2**63}",
            "static_shapes = 9223372036854775808: value should be less",
        ),
        (
            "static_shapes = true",
            "static_shapes = True: value should be a valid integer",
        ),
    ],
    "ringing": [
        ('ringing = "true"', 'bodies.link.ringing = "true": expected true or false'),
        ("ringing = 0", "bodies.link.ringing = 0: expected true or false"),
        ("", "bodies.link.ringing: missing; expected a value: the static shapes are"),
        ("rings = true", "bodies.link.rings: unknown key; did you mean 'ringing'?"),
    ],
    "mesh": [
        ('mesh = "fine"', "bodies.link.mesh = \"fine\": value should be 'model' or 'check'"),
        ("mesh = 2", "bodies.link.mesh = 2: value should be 'model' or 'check'"),
        ('mesh = "check"\nvibrations.a = 1', "not valid TOML"),
    ],
    "[bodies.link]": [
        ("[bodies.lnik]", "bodies.lnik: no such flexible body; did you mean 'link'?"),
        ("[bodies]\nlink = 3\nother = 2\n[rest]", "rest: unknown key"),
        ("[bodies]", "bodies.static_shapes = 2: expected a table with vibrations"),
        ("[[bodies]]", "bodies = [{"),
        ("[bodies.link]\n[bodies.link.link]", "bodies.link.link: unknown key"),
    ],
}


@pytest.mark.parametrize(
    ("start", "new", "message"),
    [(start, *pair) for start, pairs in LINES.items() for pair in pairs],
    ids=lambda value: value[:40],
)
def test_a_wrong_line_is_told(file, start, new, message):
    lines = [new if line.startswith(start) else line for line in TOML.splitlines()]
    assert message in refusal(file, "\n".join(lines))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "inputs_sha256: missing"),
        (b"\x89HDF\r\n\x1a\n\x00\x00", "not valid TOML"),
        (b"\xff\xfe\x00", "not valid TOML"),
        (TOML.partition("[")[0], "bodies: missing; expected a table"),
        (TOML.partition("[")[0] + "bodies = {}", "bodies.link: missing"),
        (TOML.partition("[")[0] + "[bodies]\nlink = 1.5", "bodies.link = 1.5: expected a table"),
        (b"[runs.base]\n", "expected a plan, found a case file"),
        (b"a = " + b"[" * 100000, "not valid TOML: nested too deep"),
    ],
)
def test_another_kind_of_file_is_told(file, content, message):
    assert message in refusal(file, content)


def test_a_folder_is_no_plan(file):
    file.mkdir()
    with pytest.raises(InputError, match=f"^{re.escape(str(file))}: no such plan$"):
        kept_plan(file, KNOWN, "digest")


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=5,
)
PLACES = [(key,) for key in tomllib.loads(TOML)]
PLACES += [("bodies", "link"), *(("bodies", "link", key) for key in ("vibrations", "mesh"))]
PLACES += [("bodies", "link", "static_shapes"), ("bodies", "link", "ringing")]


@given(place=st.sampled_from(PLACES), value=values)
@settings(max_examples=300)
def test_any_value_is_a_plan_or_is_told(place, value):
    """No value at any key ends in another error; what is read has values that a run can take."""
    table = tomllib.loads(TOML)
    *way, last = place
    here = table
    for key in way:
        here = here[key]
    here[last] = value
    try:
        plan = plan_of_table(Path("base.toml"), table, KNOWN)
    except InputError as error:
        said = str(error)
        assert said.startswith(f"base.toml: {place[0]}")
        return
    assert 1e-15 <= plan.rtol <= 0.1
    assert 0 <= plan.bodies["link"].static <= 20
