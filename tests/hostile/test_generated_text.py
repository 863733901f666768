"""Names in generated files are words of the language of each file, whatever they contain."""

import csv
import io
import random
import tomllib
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from harness.hostile_profile import count, tries
from samples.case_samples import HEAD, SOLVER
from samples.exchange_samples import bar, request
from samples.fmu_samples import SLIDER

from plymotion.preprocess.exchange import from_matrices
from plymotion.preprocess.exchange.__main__ import main as exchange
from plymotion.solver.errors import printable
from plymotion.solver.extras.blade.turbine import parts
from plymotion.solver.package.body.package_file import write_package
from plymotion.solver.package.body.package_schema import ModalPackage
from plymotion.solver.package.common.plain_data import toml_text, toml_value
from plymotion.solver.report.section.codes import write_beamdyn, write_hawc2
from plymotion.solver.report.section.section_text import Row, write_summary
from plymotion.solver.studies.fidelity.choice import write_plan
from plymotion.solver.studies.fidelity.plan import BodyPlan, Plan

# Ends of a string, of a comment, of a line, of a docstring; what an f-string or a format takes.
NAMES = [
    "Bob's arm",
    'a"b',
    "a');open('STRUCK', 'w')#",
    'a");open("STRUCK", "w")#',
    '"""\nopen("STRUCK", "w")\n"""',
    "a\nopen('STRUCK', 'w')",
    "a\\",
    "a{0}{body}%s",
    "x\r\nINCLUDE 'STRUCK'",
    "\u2028\x85\x07\x7f\U0001f600 -- ]]> --> <b>&amp;",
    "*/ </script> ' #{x} $(touch STRUCK) `touch STRUCK`",
    "\u202e\x1b[2J",
]
PIECES = [*"'\"\\\n\r\u2028\x0b{})`#!;=@,\t\U0001f600\u202ea1 $"]
PIECES += ["\x1b[2J", "*/", "/*", "]]>", "-->", "</script>", "%s", "${", "$(", "&lt;", "END"]
PIECES += ["open('STRUCK','w')", "BEGIN BULK", "-1", "    -1", '"""', "f'"]


def _names(number: int) -> list[str]:
    """Names of such pieces in a row."""
    chance = random.Random(5)
    return ["".join(chance.choices(PIECES, k=chance.randrange(1, 12))) for _ in range(number)]


NAMES += _names(tries(2, 25))
ON_DISK = [name.replace("/", "-") for name in NAMES]
# Files that are read line by line; what begins a line there is a card, a group or a number.
DECKS = {"dmig": ".bdf", "mbdyn": ".fem", "sid": ".SID_FEM", "uff": ".uff"}


@pytest.fixture(scope="module")
def package() -> ModalPackage:
    body = bar()
    return from_matrices(body.M, body.K, body.nodes, body.dofs, **request())


def named(package: ModalPackage, name: str) -> ModalPackage:
    """The package with this name wherever it has one."""
    interfaces = tuple(
        replace(one, name=f"{name} {i}".replace("/", "-").replace("\0", ""))
        for i, one in enumerate(package.interfaces)
    )
    labels = tuple(f"{name} {i}" for i in range(package.n_mode))
    return replace(package, body=name, interfaces=interfaces, mode_labels=labels)


@pytest.mark.parametrize("name", ON_DISK)
def test_the_script_for_exudyn_is_python_that_finds_its_package(
    package: ModalPackage, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / f"{name}.vtkhdf"
    write_package(file, package)
    for out in (tmp_path / f"{name}.py", tmp_path / "sub" / f"{name}.py"):
        assert exchange(["export", str(file), "--to", "exudyn", "-o", str(out)]) == 0
        space = {"__name__": "written", "__file__": str(out)}
        exec(compile(out.read_text(encoding="utf-8"), str(out), "exec"), space)
        read = space["read"]
        assert callable(read)
        assert read()["modes/mass"].shape == (package.n_mode, package.n_mode)
    assert not (tmp_path / "STRUCK").exists()
    count("export: hostile names in generated files", "done")


def lines_of_decks(package: ModalPackage, body: str, folder: Path) -> dict[str, list[bytes]]:
    """The lines of the package in each format."""
    file, lines = folder / "arm.vtkhdf", {}
    write_package(file, named(package, body))
    for code, suffix in DECKS.items():
        out = folder / f"arm{suffix}"
        assert exchange(["export", str(file), "--to", code, "-o", str(out)]) == 0
        lines[code] = out.read_bytes().splitlines()
    return lines


@pytest.fixture(scope="module")
def plain(
    package: ModalPackage, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, list[bytes]]:
    return lines_of_decks(package, "arm", tmp_path_factory.mktemp("plain"))


@pytest.mark.parametrize("name", NAMES)
def test_a_name_adds_no_line_to_a_deck(
    package: ModalPackage, plain: dict[str, list[bytes]], name: str, tmp_path: Path
) -> None:
    hostile = lines_of_decks(package, name, tmp_path)
    for code in DECKS:
        assert len(plain[code]) == len(hostile[code]), code
        for one, other in zip(plain[code], hostile[code], strict=True):
            assert one == other or b"arm" in one, code
    count("export: hostile names in generated files", "done")


@pytest.mark.parametrize("name", [*NAMES, "a/b", ".", "..", "/"])
def test_a_name_is_one_group_of_a_med_file(
    package: ModalPackage, name: str, tmp_path: Path
) -> None:
    file, out = tmp_path / "arm.vtkhdf", tmp_path / "arm.med"
    write_package(file, replace(package, body=name))
    assert exchange(["export", str(file), "--to", "med", "-o", str(out)]) == 0
    with h5py.File(out) as med:
        (mesh,) = med["ENS_MAA"].values()
        assert mesh.attrs["DIM"] == 3
    count("export: hostile names in generated files", "done")


@pytest.mark.parametrize("name", NAMES)
def test_titles_add_no_line_to_blade_files(name: str, tmp_path: Path) -> None:
    one = [np.diag([3.0, 1, 1, 1, 1, 1])] * 2, [np.diag([2.0, 2, 2, 1, 0.5, 0.5])] * 2
    for write in (write_beamdyn, write_hawc2):
        plain, hostile = (
            write(tmp_path / "f", [0.0, 1.0], *one, title=title).read_bytes().splitlines()
            for title in ("arm", name)
        )
        assert [a for a, b in zip(plain, hostile, strict=True) if a != b and b"arm" not in a] == []
    count("section: hostile titles in tables of blades", "done")


@pytest.mark.parametrize("name", NAMES)
def test_toml_that_we_write_is_what_it_was(name: str, tmp_path: Path) -> None:
    table = {"title": name, name: [name, {name: name}], "table": {name: {name: 1}}}
    assert tomllib.loads(toml_text(table)) == table
    values = {"speed": 1.0, "step": 1.0, "tip": 1.0, "stations": 2, "elements": 2, "modes": 1}
    words = {"file_name": "b", "title": toml_value(f"Blade of {name}"), "file": "b"}
    root = {"root": [0.0, 0.0, 0.0], "radius": 1.0, "cone": 0.0}
    case = tomllib.loads(parts()["ALONE"].format(**values, **words, **root))
    assert case["title"] == f"Blade of {name}"
    plan = Plan({"arm": BodyPlan((name,))}, False, 1e-6, "0" * 64)
    write_plan(tmp_path / "plan.toml", plan, [name])
    written = tomllib.loads((tmp_path / "plan.toml").read_text(encoding="utf-8"))
    assert written["bodies"]["arm"]["vibrations"] == [name]
    count("plan, blade: hostile names in TOML that is written", "done")


@pytest.mark.parametrize("name", NAMES)
def test_the_description_of_an_fmu_is_xml(name: str, tmp_path: Path) -> None:
    from plymotion.solver.inputs.case.load import load_case
    from plymotion.solver.inputs.case.write import write_case
    from plymotion.solver.run.coupled import Stepper
    from plymotion.solver.run.execution import read_run
    from plymotion.solver.studies.fmu.write import description

    text = SLIDER.replace("[signals.x]", f"[signals.x]\ndescription = {toml_value(name)}")
    solver = SOLVER.format(t_end=1.0, step=0.1, more="")
    (tmp_path / "case.toml").write_text(HEAD + text + solver, encoding="utf-8")
    case = load_case(tmp_path / "case.toml")
    write_case(case, tmp_path / "out")
    (run,) = (tmp_path / "out/runs").glob("*.json")
    stepper = Stepper(read_run(run), None)
    for version, kind in (("2.0", "ScalarVariable"), ("3.0", "Float64")):
        xml = description(stepper, "x", "{0}", name, (1.0, 0.1), version)
        root = ET.fromstring(xml)
        (signal,) = (v for v in root.iter(kind) if v.get("name") == "signals.x")
        assert signal.get("description", "").startswith(printable(name[:1].strip()))
    count("export: hostile words in the XML of an FMU", "done")


@pytest.mark.parametrize("name", ["=1+1", "+1", "-1", "@SUM(1)", "\t=1"])
def test_no_cell_of_a_table_is_a_formula(name: str, tmp_path: Path) -> None:
    file = write_summary(tmp_path, "s", [Row(name, "failed", {}, None, f"{name}: wrong")])[0]
    _, row = csv.reader(io.StringIO(file.read_text(encoding="utf-8"), newline=""))
    assert (row[0], row[-1]) == (f"'{name}", f"'{name}: wrong")
