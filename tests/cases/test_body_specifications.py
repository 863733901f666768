"""Specifications of all cases: complete, shared between runs, and those of the shipped packages."""

import json
from pathlib import Path

import pytest

from plymotion.solver.inputs.case.design import Case
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.package import read_package
from plymotion.solver.package.common.plain_data import check_form
from plymotion.solver.package.specification import BeamSpecification, ShellSpecification

FORMS = {"beam": BeamSpecification, "shell": ShellSpecification}
CASES = ("double-pendulum", "double-pendulum-shell", "rotating-blade", "actuated-beam", "spin-up")


@pytest.fixture(scope="module", params=CASES)
def case(request: pytest.FixtureRequest, repository: Path) -> Case:
    return load_case(repository / "cases" / request.param / "case.toml", sweeps=())


def test_preprocessor_finds_every_key(case: Case) -> None:
    for bodies in case.bodies.values():
        for spec in bodies.values():
            check_form(spec.content, FORMS[spec.content["kind"]])


def test_hash_is_that_of_the_shipped_packages(case: Case, repository: Path) -> None:
    specs = {spec.inputs_sha256 for bodies in case.bodies.values() for spec in bodies.values()}
    files = (repository / "tests/packages" / case.name).glob("*.vtkhdf")
    assert {read_package(file).provenance["inputs_sha256"] for file in files} == specs


def test_runs_share_the_specification_of_a_body(repository: Path) -> None:
    bodies = load_case(repository / "cases/double-pendulum-limits/case.toml").bodies
    assert bodies["isotropic-soft-free"]["arm"] is bodies["isotropic-soft-following"]["arm"]


def test_a_run_with_error_bars_has_the_packages_of_the_others(
    repository: Path, tmp_path: Path
) -> None:
    """One package of each body, with its errors, whichever run comes first."""
    text = (repository / "cases/double-pendulum/case.toml").read_text()
    runs = (
        '[variants.barred.solver]\nerror_bars = true\n[runs.a]\n[runs.b]\nvariants = ["barred"]\n'
    )
    (tmp_path / "case.toml").write_text(text[: text.index("[runs.")] + runs)
    write_case(load_case(tmp_path / "case.toml"), tmp_path / "out", None)
    first, second = (json.loads((tmp_path / f"out/runs/{n}.json").read_text()) for n in "ab")
    assert first["packages"] == second["packages"]
    specs = [json.loads(path.read_text()) for path in sorted((tmp_path / "out/bodies").iterdir())]
    assert [(spec["body"], spec["errors"]) for spec in specs] == [("arm", True), ("hand", True)]
