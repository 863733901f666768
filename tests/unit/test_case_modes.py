"""Reference conditions and static modes in a case file: what is accepted, what is said."""

import re
from pathlib import Path

import pytest

from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.package import read_package

CASE = """
format = 1
title = "a bar"
[runs.one]
[solver]
t_end = 1.0
output_step = 0.1
[materials.steel]
kind = "isotropic"
E = 210e9
nu = 0.3
rho = 7850.0
[sections.bar]
shape = "rectangle"
width = 0.02
height = 0.05
[bodies.bar]
kind = "beam"
length = 1.0
section = "bar"
material = "steel"
modes = [{modes}]
reference = {reference}
[bodies.bar.interfaces]
root = {{ at = "start" }}
foot = {{ at = 0.0 }}
mid = {{ at = 0.5 }}
tip = {{ at = "end" }}
"""
BENDING = '{ kind = "bending-xy", count = 2 }'
CLAMPED = "{}"


def written(folder: Path, modes: str = BENDING, reference: str = CLAMPED) -> Path:
    file = folder / "case.toml"
    file.write_text(CASE.format(modes=modes, reference=reference))
    return file


def spec_of(file: Path) -> dict:
    return load_case(file).bodies["one"]["bar"].content


@pytest.mark.parametrize(
    ("reference", "expected"),
    [
        ("{}", {"kind": "clamped", "at": "root"}),
        ('{ at = "tip" }', {"kind": "clamped", "at": "tip"}),
        ('{ kind = "chord", at = ["root", "tip"] }', {"kind": "chord", "at": ["root", "tip"]}),
        ('{ kind = "mean-axis" }', {"kind": "mean-axis"}),
    ],
)
def test_reference_condition_reaches_the_preprocessor(
    reference: str, expected: dict, tmp_path: Path
) -> None:
    spec = spec_of(written(tmp_path, reference=reference))
    assert spec["reference"] == expected
    assert read_spec(spec).reference.kind == expected["kind"]


def test_static_modes_reach_the_preprocessor(tmp_path: Path) -> None:
    modes = (
        f'{BENDING}, {{ kind = "attachment", at = "mid", directions = ["y"] }}, '
        '{ kind = "static-axial" }, { kind = "attachment", at = "tip" }'
    )
    found = read_spec(spec_of(written(tmp_path, modes))).modes
    assert found.attachments[0] == ("mid", "y")
    assert [at for at, _ in found.attachments[1:]] == ["tip"] * 6
    assert found.static_axial
    asked = '{ kind = "spinning-xz", count = 4 }, { kind = "spinning-xy", count = 2 }'
    found = read_spec(spec_of(written(tmp_path, asked))).modes
    assert found.spinning == (("spinning-xz", 4), ("spinning-xy", 2))


BAD = {
    "kind": ("", '{ kind = "chrod" }', r"reference\.kind = \"chrod\": .*'chord'"),
    "one place": ("", '{ kind = "chord", at = "root" }', r"expected `at` with two interfaces"),
    "three": ("", '{ kind = "chord", at = ["a", "b", "c"] }', "expected `at` with two interfaces"),
    "a place": ("", '{ kind = "mean-axis", at = "root" }', "no `at` of a mean axis, or two"),
    "name": ("", '{ kind = "chord", at = ["root", "tipp"] }', r"at = \"tipp\": .*mean 'tip'"),
    "same": ("", '{ kind = "chord", at = ["root", "foot"] }', "expected two different places"),
    "clamped": ("", '{ at = "rot" }', r"bodies\.bar\.reference\.at = \"rot\": .*mean 'root'"),
    "attachment": ('{ kind = "attachment", at = "mdi" }', "{}", r"modes\.0\.at = \"mdi\".*'mid'"),
    "direction": (
        '{ kind = "attachment", at = "mid", directions = ["yy"] }',
        "{}",
        r"modes\.0\.directions\.0 = \"yy\": value should be 'x', 'y'",
    ),
    "mode": ('{ kind = "atachment", at = "mid" }', "{}", r"modes\.0\.kind = \"atachment\".*mean"),
    "spinning": (
        '{ kind = "spinning-xz", count = 4 }',
        '{ kind = "mean-axis" }',
        r'modes\.0\.kind = "spinning-xz": expected reference\.kind "clamped" or "chord"',
    ),
    "how many": ('{ kind = "spinning-xz", count = 9 }', "{}", r"modes\.0\.count = 9: .*8"),
    "count": ('{ kind = "static-axial", count = 2 }', "{}", r"modes\.0\.count: unknown key"),
}


@pytest.mark.parametrize("name", list(BAD))
def test_message_names_key_value_and_expectation(name: str, tmp_path: Path) -> None:
    modes, reference, message = BAD[name]
    with pytest.raises(InputError) as error:
        load_case(written(tmp_path, modes or BENDING, reference or CLAMPED))
    assert re.search(message, str(error.value)), error.value
    assert "case.toml" in str(error.value)


def test_packages_of_clamped_bodies_stay_the_same(repository: Path) -> None:
    """What a clamped body is made from has the hash that shipped packages hold."""
    case = load_case(repository / "cases/double-pendulum/case.toml", sweeps=())
    folder = repository / "tests/packages/double-pendulum"
    package = read_package(folder / "arm.isotropic.vtkhdf")
    found = case.bodies["isotropic"]["arm"].inputs_sha256
    assert found == package.provenance["inputs_sha256"]
