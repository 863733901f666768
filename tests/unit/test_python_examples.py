"""Every public name has examples, and they do what they say; so do those of docs/python.md."""

import contextlib
import doctest
import importlib.util
import inspect
import re
from dataclasses import replace
from pathlib import Path

import pytest
from samples.section_samples import rectangle
from samples.shell_file_samples import plate

import plymotion
from plymotion.api.case import ByName
from plymotion.api.sweeping import SweepSignal
from plymotion.solver.package import read_package, write_package
from plymotion.solver.package.section.section_file import write_section
from plymotion.solver.package.shell.shell_file import write_shell

PAGE = Path("docs/python.md").resolve()
ROD = Path("tests/packages/slider-crank/rod.steel.vtkhdf").resolve()
SOLID = {  # numbers of a bar, as preprocess/solid/solid_analysis.py puts them into its package
    "cells": 96,
    "cell": "tetrahedron",
    "size": 0.02,
    "unknowns": 693,
    "mass": 2.4,
    "centre": [0.0, 0.0, 0.0],
    "inertia": [[0.001, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.02]],
    "exact": None,
    "free_hz": [812.5, 1630.0],
}
ROTOR = """
format = 1
title = "A blade that flaps on a hub"

[bodies.hub]
kind = "rigid"
mass = 1.0
inertia = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]
interfaces = { axle = { position = [0.0, 0.0, 0.0] }, rim = { position = [0.1, 0.0, 0.0] } }

[bodies.blade]
kind = "rigid"
mass = 3.0
position = [0.1, 0.0, 0.0]
centre = [0.5, 0.0, 0.0]
inertia = [[0.001, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 0.25]]
interfaces = { root = { position = [0.0, 0.0, 0.0] } }

[ground.axle]
position = [0.0, 0.0, 0.0]

[joints.axle]
kind = "revolute"
between = ["ground.axle", "hub.axle"]
axis = [0.0, 0.0, 1.0]

[joints.flap]
kind = "revolute"
between = ["hub.rim", "blade.root"]
axis = [0.0, 1.0, 0.0]

[solver]
t_end = 1.0
output_step = 0.1

[runs.base]
"""
HAS_PANDAS = importlib.util.find_spec("pandas") is not None


def _blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def _examples() -> dict[str, object]:
    """Public names and the public members that their classes define, by name."""
    found: dict[str, object] = {}
    # the names, and what is met on the way
    things = {name: getattr(plymotion, name) for name in plymotion.__all__}
    for name, thing in {**things, "SweepSignal": SweepSignal, "ByName": ByName}.items():
        if not getattr(thing, "__module__", "").startswith("plymotion.api"):
            continue  # the version, and errors
        found[name] = thing
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                has_doc = isinstance(value, property | classmethod) or callable(value)
                if not member.startswith("_") and (has_doc or hasattr(value, "attrname")):
                    found[f"{name}.{member}"] = value
    return found


EXAMPLES = _examples()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A current folder with the files that the examples name."""
    pytest.importorskip("matplotlib").use("Agg")
    from matplotlib import pyplot

    found = tmp_path_factory.mktemp("examples")
    (found / "pendulum.toml").write_text(_blocks("toml")[0], encoding="utf-8")
    section = replace(rectangle(), provenance={"dofs": 351, "seconds": 0.25})
    write_section(found / "bar.vtkhdf", section)
    write_shell(found / "plate.vtkhdf", plate())
    (found / "rod.vtkhdf").write_bytes(ROD.read_bytes())
    rod = read_package(ROD)
    provenance = {**rod.provenance, "solid": SOLID, "seconds": {}, "warnings": []}
    write_package(found / "bracket.vtkhdf", replace(rod, provenance=provenance))
    (found / "rotor.toml").write_text(ROTOR, encoding="utf-8")
    with contextlib.chdir(found):
        yield found
    pyplot.close("all")


def _run(text: str, name: str) -> None:
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, 0)
    assert test.examples
    told: list[str] = []
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    doctest.DocTestRunner(verbose=False, optionflags=flags).run(test, out=told.append)
    assert not told, "\n".join(told)


def test_all_names_are_known():
    assert {"load", "run", "sweep", "Section.from_file", "Result.energies"} <= EXAMPLES.keys()


@pytest.mark.parametrize("name", EXAMPLES)
def test_example(name, folder):
    text = inspect.getdoc(EXAMPLES[name]) or ""
    assert ">>>" in text, f"{name}: expected an example in its docstring"
    if "to_pandas" in text and not HAS_PANDAS:
        pytest.skip("pandas is not installed")
    _run(text, name)


@pytest.mark.parametrize("number", range(len(_blocks("python"))))
def test_block_of_the_page(number, folder):
    exec(compile(_blocks("python")[number], f"{PAGE.name}, block {number}", "exec"), {})
