"""Error bars of runs beside their true errors, and where they are said."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.case_samples import case_runs
from samples.fidelity_samples import Table, chosen_modes, pendulum, true_signals

from plymotion.solver.inputs.case.bodies.specifications import check_fidelity
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.report.report_data import Story
from plymotion.solver.report.sections import signals_section
from plymotion.solver.report.table import summary_table
from plymotion.solver.results import Signal
from plymotion.solver.results.file import read_result
from plymotion.solver.run.error_bars import largest_difference, not_contained, with_error_bars
from plymotion.solver.run.execution import execute, run_file
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.studies.runs import error_bars_line

silent = partial(execute, progress=False)


def barred(spec: RunSpec) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    result, summary = silent(spec)
    with_error_bars(summary, spec, result, silent)
    return {signal.name: signal.values for signal in result.signals}, summary


BENDING = {"kind": "bending-xy", "count": 3}
TIP = {"kind": "attachment", "at": "tip", "directions": ["x", "y"]}


@pytest.mark.parametrize(
    ("side", "modes", "solver"),
    [
        # errors of: omitted vibrations; stiffening; two steps, whose number does not change
        # with the tolerance
        ("stiff", [BENDING], {"rtol": 1e-6, "geometric_stiffening": True}),
        ("stiff", [BENDING, TIP], {"rtol": 1e-6}),
        ("soft", [BENDING, TIP], {"rtol": 1.4e-4, "geometric_stiffening": True}),
    ],
)
def test_bars_contain_the_errors(side: str, modes: list[Table], solver: Table) -> None:
    table = pendulum(speed=4.0, t_end=0.2)
    table["solver"]["start"] = "quasi-static"
    found, summary = barred(chosen_modes(table, side, modes, **solver))
    exact = true_signals(table, side, 1e-8)
    assert summary["error_bars"]["reason"] == ""
    for name, values in found.items():
        error = np.abs(values - exact[name]).max()
        bar = summary["signals"][name]["error_bar"]
        assert error <= bar <= 30.0 * error, name


def test_a_rigid_mechanism_has_the_error_of_its_tolerance() -> None:
    table = pendulum(t_end=1.0)
    inertia = [[1e-4, 0.0, 0.0], [0.0, 1e-2, 0.0], [0.0, 0.0, 1e-2]]
    places = {name: {"position": [x, 0.0, 0.0]} for name, x in (("root", 0.0), ("tip", 0.6))}
    body = {"kind": "rigid", "mass": 0.6, "inertia": inertia, "interfaces": places}
    del table["joints"]["hinge0"]["drive"], table["fidelity"], table["signals"]["bending"]
    table |= {"bodies": {"link0": body}}
    spec = RunSpec("sample", "rigid", Mechanism.model_validate(table), {})
    spec = spec.changed({"solver.rtol": 1e-7, "solver.t_end": 10.0})
    found, summary = barred(spec)
    exact, _ = silent(spec.changed({"solver.rtol": 1e-11}))
    assert summary["error_bars"]["not_contained"] == []
    assert not error_bars_line(summary).endswith(")")
    for signal in exact.signals:
        error = np.abs(found[signal.name] - signal.values).max()
        assert error <= summary["signals"][signal.name]["error_bar"] <= 30.0 * error


def test_a_run_file_has_them_where_it_asks(repository: Path, tmp_path: Path) -> None:
    file = case_runs(repository, "double-pendulum", tmp_path / "build") / "layup-1.json"
    table = json.loads(file.read_text())
    table["mechanism"]["solver"] |= {"t_end": 0.05, "error_bars": True}
    file.write_text(json.dumps(table))
    summary = run_file(file, tmp_path / "out", progress=False)
    assert json.loads((tmp_path / "out/summary.json").read_text())["error_bars"]["cpu_s"] > 0.0
    assert all(signal["error_bar"] > 0.0 for signal in summary["signals"].values())
    left_out = "theory of beams and shells apart from held ends, mesh and section of arm and hand"
    assert f"without {left_out}" in error_bars_line(summary)
    assert "+-" in summary_table([summary])
    result = read_result(tmp_path / "out/result.vtkhdf")
    words = signals_section([Story("layup-1", "Lay-up 1", summary, result)])
    assert "error bar</th>" in words
    assert f"They do not contain: {left_out}." in words


def test_a_second_run_that_ends_early_leaves_no_bars() -> None:
    spec = chosen_modes(pendulum(t_end=0.1), "stiff", [BENDING])
    result, summary = silent(spec)
    with_error_bars(summary, spec, result, lambda one: silent(one.changed({"solver.t_end": 0.05})))
    assert {signal["error_bar"] for signal in summary["signals"].values()} == {None}
    assert "the coarser run ended early" in error_bars_line(summary)


def test_bodies_without_second_order_data_are_said_to_lack_stiffening() -> None:
    spec = chosen_modes(pendulum(), "stiff", [BENDING])
    assert not any("geometric stiffening" in line for line in not_contained(spec))
    linear = {name: replace(p, second_order=None) for name, p in spec.packages.items()}
    assert "geometric stiffening of link0" in not_contained(replace(spec, packages=linear))


def test_signals_that_are_both_infinite_or_not_a_number_do_not_differ() -> None:
    one, other = np.array([np.inf, np.nan, 3.0]), np.array([np.inf, np.nan, 3.5])
    as_signal = partial(Signal, "reserve", "-", "")
    assert largest_difference(as_signal(one), as_signal(other)) == 0.5
    other[1] = 1.0
    assert np.isnan(largest_difference(as_signal(one), as_signal(other)))


def test_reactions_at_a_sudden_start_have_no_bar() -> None:
    """No number of modes gives them; bars were up to three times too small."""
    table = pendulum(t_end=0.1)
    table["signals"]["size"] = {"kind": "norm", "of": ["force"]}
    _, summary = barred(chosen_modes(table, "soft", [BENDING]))
    assert "loads-begin-suddenly" in [found["code"] for found in summary["warnings"]]
    assert summary["signals"]["force"]["error_bar"] is None
    assert summary["signals"]["size"]["error_bar"] is None
    assert summary["signals"]["bending"]["error_bar"] > 0.0
    assert "force, because loads begin suddenly" in error_bars_line(summary)


def test_a_planned_run_states_its_errors_otherwise() -> None:
    table = pendulum()
    table["solver"]["error_bars"] = True
    found = check_fidelity(Mechanism.model_validate(table))
    assert "solver.error_bars: expected false with [fidelity], which states errors" in found
