"""Rainflow counting, S-N lines and Miner sums: the standard's example and closed forms."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from samples.case_samples import case_runs, run_case

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.report.report_page import make_report
from plymotion.solver.results import read_result
from plymotion.solver.run.execution import read_run
from plymotion.solver.strength.fatigue import (
    Cycles,
    StressLife,
    Turning,
    fatigue_summary,
    rainflow_cycles,
)
from plymotion.solver.studies.sweep.file import read_sweep

LINE = StressLife(np.array([400e6, 100e6]), np.array([1e3, 1e7]))
SLOPE = math.log(1e7 / 1e3) / math.log(4.0)
STRESS = '\n[signals.root]\nkind = "ply_stress"\nbody = "hand"\nx = 0.0\ncomponent = "11"\n'
FATIGUE = "\n[materials.graphite-epoxy.fatigue.fibre]\namplitude = [2e6, 1e4]\ncycles = [10, 1e4]\n"

counted = pytest.mark.usefixtures("_rainflow")


@pytest.fixture
def _rainflow() -> None:
    pytest.importorskip("rainflow")


def turning(values: np.ndarray, blocks: int = 1) -> np.ndarray:
    found = Turning()
    for block in np.array_split(values, blocks):
        found.take(block)
    return found.points()


@counted
def test_example_of_the_standard() -> None:
    """ASTM E1049-85, figure 6: ranges 3, 4, 6, 8, 9 with 0.5, 1.5, 0.5, 1, 0.5 cycles."""
    history = np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0])
    cycles = rainflow_cycles(turning(history).tolist())
    counts = {r: cycles.counts[cycles.ranges == r].sum() for r in np.unique(cycles.ranges)}
    assert counts == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def test_turning_points_in_blocks_are_those_of_the_whole() -> None:
    rng = np.random.default_rng(3)
    history = np.repeat(np.round(rng.normal(size=300), 1), rng.integers(1, 4, 300))
    whole = turning(history)
    for blocks in (2, 7, 50):
        assert np.array_equal(turning(history, blocks), whole)
    rise = np.sign(np.diff(whole))
    assert (rise[1:] * rise[:-1] == -1.0).all()
    assert (whole[0], whole[-1], whole.max()) == (history[0], history[-1], history.max())
    assert np.array_equal(turning(np.array([1.0, 1.0])), [1.0])
    assert np.array_equal(turning(np.array([1.0, 2.0, 5.0]), 3), [1.0, 5.0])


def test_line_over_logarithms() -> None:
    """N = N_1 (S_1 / S)^k between the points and beyond; at least one cycle; none below a limit."""
    S = np.array([400e6, 200e6, 100e6, 50e6])
    expected = 1e3 * (400e6 / S) ** SLOPE
    assert LINE.life(S, np.zeros(4)) == pytest.approx(expected, rel=1e-12)
    limited = StressLife(LINE.amplitude, LINE.cycles, limit=100e6)
    assert limited.life(S, np.zeros(4)).tolist()[2:] == [math.inf, math.inf]
    assert LINE.life(np.array([1e12]), np.zeros(1)) == pytest.approx([1.0])
    three = StressLife(np.array([300e6, 200e6, 150e6]), np.array([1e2, 1e4, 1e8]))
    assert three.life(np.array([200e6, math.sqrt(200e6 * 150e6)]), np.zeros(2)) == pytest.approx(
        [1e4, 1e6], rel=1e-9
    )


def test_goodman() -> None:
    """A mean of half the ultimate stress doubles an amplitude; one in compression does nothing."""
    line = StressLife(LINE.amplitude, LINE.cycles, ultimate=600e6)
    amplitude, mean = np.array([100e6, 100e6, 100e6]), np.array([300e6, -300e6, 600e6])
    expected = [1e3 * 2.0**SLOPE, 1e7, 1.0]  # at the ultimate stress the first cycle breaks it
    assert line.life(amplitude, mean) == pytest.approx(expected, rel=1e-12)


@counted
@pytest.mark.parametrize("count", [1, 25])
def test_miner_sum_of_a_constant_amplitude(count: int) -> None:
    """n cycles of one amplitude: n / N, whatever the sampling."""
    t = np.linspace(0.0, count, 40 * count + 1)
    found = fatigue_summary(rainflow_cycles(turning(200e6 * np.cos(2 * np.pi * t)).tolist()), LINE)
    expected = count / (1e3 * 2.0**SLOPE)
    assert found["damage"] == pytest.approx(expected, rel=1e-12)
    assert found["repetitions"] == pytest.approx(1.0 / expected, rel=1e-12)
    assert found["cycles"] == pytest.approx(count)
    assert found["largest_range"] == pytest.approx(400e6)
    assert [row["cycles"] for row in found["classes"]] == pytest.approx([count])


def test_classes_add_up_to_the_sum() -> None:
    rng = np.random.default_rng(8)
    cycles = Cycles(rng.uniform(1e6, 6e8, 300), np.zeros(300), rng.choice([0.5, 1.0], 300))
    found = fatigue_summary(cycles, LINE)
    assert sum(row["damage"] for row in found["classes"]) == pytest.approx(found["damage"])
    assert sum(row["cycles"] for row in found["classes"]) == pytest.approx(cycles.counts.sum())
    assert len(found["classes"]) == 16
    nothing = fatigue_summary(Cycles(np.zeros(0), np.zeros(0), np.zeros(0)), LINE)
    assert (nothing["damage"], nothing["classes"]) == (0.0, [])


def with_fatigue(repository: Path, folder: Path, more: str = "") -> Path:
    """The case of the double pendulum with a stress and its S-N line."""
    text = (repository / "cases/double-pendulum/case.toml").read_text()
    file = folder / "case.toml"
    file.write_text(text + STRESS + FATIGUE + more)
    for name in ("sections", "meshes"):
        if (repository / f"cases/double-pendulum/{name}").exists():
            (folder / name).symlink_to(repository / f"cases/double-pendulum/{name}")
    return file


@counted
def test_run_sweep_and_report_have_the_miner_sum(repository: Path, tmp_path: Path) -> None:
    from plymotion.solver.inputs.case.write import write_case

    sweep = (
        '\n[sweeps.speed]\nrun = "layup-1"\nsignals = ["root", "tip_y"]\n'
        '[sweeps.speed.vary]\n"joints.shoulder.drive.speed" = [5.0, 15.0]\n'
    )
    case = load_case(with_fatigue(repository, tmp_path, sweep), coarse=False)
    build = tmp_path / "build"
    write_case(case, build, repository / "tests/packages/double-pendulum")
    file = build / "runs/layup-1.json"
    table = json.loads(file.read_text())
    table["mechanism"]["solver"] |= {"t_end": 0.1}
    table.pop("checked")
    file.write_text(json.dumps(table))
    assert main(["run", str(file), "--quiet"]) == 0
    summary = json.loads((build / "layup-1/summary.json").read_text())
    (entry,) = summary["fatigue"].values()
    result = read_result(build / "layup-1/result.vtkhdf")
    (stress,) = (s.values for s in result.signals if s.name == "root")
    cycles = rainflow_cycles(stress.tolist())
    line = StressLife(np.array([2e6, 1e4]), np.array([10.0, 1e4]))
    assert entry["damage"] == pytest.approx(float(line.damage(cycles).sum()), rel=1e-12)
    assert entry["damage"] > 0.0
    pytest.importorskip("matplotlib")
    page = make_report(build, ["layup-1"], {}).read_text()
    assert ">Fatigue</h2>" in page
    assert f"{entry['damage']:.4g}" in page

    plan = build / "sweeps/speed.json"
    assert main(["sweep", str(plan), "--no-figures", "--quiet"]) == 0
    found = read_sweep(next((build / "sweeps").rglob("sweep.h5")))
    damage = found.signal("root", "damage")
    assert damage.shape == (2,)
    assert damage[1] > damage[0] > 0.0
    assert "damage" not in found.measures("tip_y")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("amplitude = [2e8, 1e8]\ncycles = [1e3, 1e4, 1e5]\n", "as many cycles as amplitudes"),
        ("amplitude = [1e8, 2e8]\ncycles = [1e3, 1e6]\n", "expected descending stresses above 0"),
        ("amplitude = [2e8, 1e8]\ncycles = [1e6, 1e3]\n", "expected ascending numbers from 1 on"),
        ("amplitude = [2e8, 1e8]\ncycle = [1e6, 1e3]\n", "did you mean 'cycles'"),
    ],
)
def test_wrong_data_are_named(repository: Path, tmp_path: Path, text: str, message: str) -> None:
    file = with_fatigue(repository, tmp_path)
    head = "[materials.graphite-epoxy.fatigue.fibre]\n"
    file.write_text(file.read_text().replace(FATIGUE, "\n" + head + text))
    with pytest.raises(InputError, match=message) as told:
        load_case(file)
    assert "materials.graphite-epoxy" in str(told.value)


def test_bodies_do_not_depend_on_fatigue(repository: Path, tmp_path: Path) -> None:
    """S-N data are of a run: a package that was built without them still fits."""
    from plymotion.solver.inputs.case.write import write_case

    case = load_case(with_fatigue(repository, tmp_path))
    write_case(case, tmp_path / "build", repository / "tests/packages/double-pendulum")
    plain = case_runs(repository, "double-pendulum", tmp_path / "plain") / "layup-1.json"
    spec = read_run(tmp_path / "build/runs/layup-1.json")
    assert spec.mechanism.materials["graphite-epoxy"].fatigue is not None
    one, two = (json.loads(f.read_text()) for f in (plain, tmp_path / "build/runs/layup-1.json"))
    hashes = [[p["inputs_sha256"] for p in t["packages"].values()] for t in (one, two)]
    assert hashes[0] == hashes[1]
    _, signals, summary = run_case(plain, t_end=0.01)
    assert summary["fatigue"] == {}
    assert "tip_y" in signals
