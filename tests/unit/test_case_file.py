"""Bad case files: one line that names file, key, value and expectation; good ones resolve."""

import re
import tomllib
from pathlib import Path

import pytest

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.inputs.manual import case_page

BAD = {
    "unknown key": (
        "length = 0.545",
        "lenght = 0.545",
        r"bodies\.arm\.lenght: unknown key; did you mean 'length'",
    ),
    "unknown table": ("[solver]", "[solvr]", r"solvr: unknown key; did you mean 'solver'"),
    "negative thickness": (
        "height = 0.015",
        "height = -0.015",
        r"sections\.arm\.height = -0\.015: .*greater than 0",
    ),
    "isotropic nu": (
        "nu = 0.3\n",
        "nu = 0.7\n",
        r"materials\.aluminium\.nu = 0\.7: .*less than 0\.5",
    ),
    "orthotropic nu": (
        "nu12 = 0.3",
        "nu12 = 4.3",
        r"materials\.graphite-epoxy\.nu12 = 4\.3: expected nu12\^2 < E1/E2",
    ),
    "nus together": (
        "nu12 = 0.3\nnu13 = 0.3\nnu23 = 0.218837",
        "nu12 = 3.0\nnu13 = 3.0\nnu23 = 0.9",
        r"materials\.graphite-epoxy: .*together are too large",
    ),
    "no such body": (
        '"arm.tip", "hand.root"',
        '"armm.tip", "hand.root"',
        r'joints\.elbow\.between = "armm\.tip": there is no body "armm"; did you mean \'arm\'',
    ),
    "no such interface": (
        '"arm.tip", "hand.root"',
        '"arm.tipp", "hand.root"',
        r'body "arm" has no interface "tipp"; did you mean \'tip\'',
    ),
    "kind": (
        'kind = "beam"',
        'kind = "baem"',
        r'bodies\.arm\.kind = "baem": expected one of .*"beam"',
    ),
    "drive": ("speed = 20.0", "sped = 20.0", r"drive\.sped: unknown key; did you mean 'speed'"),
    "two laws": ("speed = 20.0", "speed = 20.0, polynomial = [0, 1]", "found speed and polynomial"),
    "type": ("t_end = 1.0", 't_end = "long"', r'solver\.t_end = "long": .*number'),
    "no node": ("elements = 24", "elements = 1", r"arm\.elements = 1: expected at least 2"),
    "variant": ('["layup-1"]', '["layup-3"]', r'"layup-3": no such variant; did you mean'),
    "version": ("format = 1", "format = 2", "format = 2: value should be 1"),
    "toml": ("[solver]", "[solver", "not valid TOML"),
    "decimal comma": ("t_end = 1.0", "t_end = 1,0", r"t_end = 1,0; expected numbers such as 0\.5"),
    "text without quotes": ('"beam"', "beam", "Invalid value .*: kind = beam; .*texts in quotes"),
    "umlaut": ("[solver]", "[\u00f6l]", r"\[\u00f6l\]; expected letters A to Z in names"),
    "key below its table": (
        "t_end = 1.0",
        't_end = 1.0\nunits = "mm"',
        "solver.units: unknown key: it belongs at the top of the file, above the first table",
    ),
    "plural of a key of the table": (
        "[sweeps.layup-speed]",
        '[sweeps.layup-speed]\nruns = "layup-1"',
        r"sweeps\.layup-speed\.runs: unknown key; did you mean 'run'",
    ),
    "unit in a text": ("E1 = 129.207e9", 'E1 = "129.2 GPa"', r"number \[Pa\], .* without a unit"),
    "true in quotes": (
        "geometric_stiffening = true",
        'geometric_stiffening = "yes"',
        'geometric_stiffening = "yes": expected true or false',
    ),
    "keys of another shape": (
        'shape = "rectangle"\nwidth = 0.060',
        'shape = "tube"\nwidth = 0.060',
        r'sections\.arm\.shape = "tube": width, height are keys of rectangle',
    ),
    "misspelt in a variant": (
        "[variants.layup-1.bodies]\narm =",
        "[variants.layup-1.bodies]\narmm =",
        r"bodies\.armm: not in the case; did you mean 'arm'\? .* \(run layup-1, variant layup-1\)",
    ),
    "word of others": ("\nE1 = ", "\nE = ", r"E: unknown key; did you mean 'E1'"),
    "length of a list": ("[0.0, -9.81, 0.0]", "[0.0, -9.81]", "expected a list of 3 numbers"),
    "figure": (
        'signal = "arm_mid"',
        'signal = "arm_mod"',
        r"no such signal; did you mean 'arm_mid'",
    ),
}


@pytest.fixture(scope="module")
def source(repository) -> str:
    return (repository / "cases/double-pendulum/case.toml").read_text()


@pytest.mark.parametrize("name", list(BAD))
def test_bad_input_exits_with_2_and_writes_nothing(name, source, tmp_path, capsys):
    old, new, expected = BAD[name]
    assert old in source
    file = tmp_path / "case.toml"
    file.write_text(source.replace(old, new, 1))
    out = tmp_path / "build"
    assert main(["check", str(file), "--out", str(out)]) == 2
    message = capsys.readouterr().err
    assert str(file) in message
    assert re.search(expected, message), message
    assert not out.exists()


def test_missing_tables_are_named_as_they_are_written(source, tmp_path):
    file = tmp_path / "case.toml"
    file.write_text('format = 1\ntitle = "A section"\n[mesh]\nshape = "box"\n')
    with pytest.raises(
        InputError, match=r"case\.toml: runs: missing; expected a table \[runs\.NAME\]"
    ):
        load_case(file)
    file.write_text(re.sub(r"^\[solver\]\n(.+\n)+", "", source, flags=re.MULTILINE))
    with pytest.raises(InputError, match=r"solver: missing; expected a table \[solver\]"):
        load_case(file)


def test_missing_file(tmp_path, capsys):
    assert main(["check", str(tmp_path / "case.toml")]) == 2
    assert "no such case file" in capsys.readouterr().err


def test_variants_are_merged_in_order(repository):
    case = load_case(repository / "cases/double-pendulum-limits/case.toml")
    assert list(case.runs)[:2] == ["isotropic-paper", "layup-2-linear"]
    run = case.runs["layup-2-soft-following"]
    assert run.bodies["arm"].material == "graphite-epoxy"
    assert run.bodies["hand"].ply_angle_deg == 30.0
    assert run.bodies["arm"].x2_axis == [0.0, 0.0, 1.0]
    assert run.bodies["hand"].angular_velocity == [0.0, 0.0, 20.0]
    assert case.runs["isotropic-paper"].bodies["hand"].angular_velocity == [0.0, 0.0, 0.0]


def test_only_what_changed_is_rewritten(source, tmp_path):
    """After touching only the integrator settings no body's specification changes."""
    file, out = tmp_path / "case" / "case.toml", tmp_path / "build"
    file.parent.mkdir()
    file.write_text(source)
    write_case(load_case(file), out)
    specs = sorted((out / "bodies").glob("*.json"))
    assert len(specs) == 6  # two links, three materials
    before = {p: p.stat().st_mtime_ns for p in out.rglob("*.json")}
    file.write_text(source.replace("rtol = 1e-6", "rtol = 1e-4", 1))
    write_case(load_case(file), out)
    changed = {p.parent.name for p, t in before.items() if p.stat().st_mtime_ns != t}
    assert changed == {"runs", "sweeps"}


def test_figures_and_runs_of_the_reference_case_exist(repository):
    table = tomllib.loads((repository / "cases/double-pendulum/case.toml").read_text())
    for figure in table["figures"].values():
        assert set(figure["runs"]) <= set(table["runs"])


def test_reference_page_is_current(repository):
    """docs/case-reference.md is what `make docs` writes."""
    assert (repository / "docs/case-reference.md").read_text() == case_page()


def test_every_key_has_a_meaning():
    rows = [r for r in case_page().splitlines() if r.startswith("| `")]
    assert len(rows) > 80
    for row in rows:
        assert row.split("|")[-2].strip(), f"no meaning: {row}"


def test_errors_come_together(source, tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(source.replace("nu = 0.3\n", "nu = 0.7\n").replace("0.545\n", "-0.545\n"))
    with pytest.raises(InputError) as error:
        load_case(Path(file))
    assert len(str(error.value).splitlines()) >= 2


def test_case_of_the_first_steps_is_valid(repository, tmp_path):
    text = (repository / "docs/first-steps.md").read_text()
    file = tmp_path / "case.toml"
    file.write_text(re.search(r"```toml\n(.*?)```", text, re.DOTALL)[1])
    assert list(load_case(file).runs) == ["base"]
