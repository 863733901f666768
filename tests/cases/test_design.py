"""Studies of `[design]`: closed forms, limits, invalid designs, restarts, mistakes of the user."""

import copy
import json
import re
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import plymotion as pm
from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.package import write_package
from plymotion.solver.package.common.design import Derivative
from plymotion.solver.package.common.plain_data import toml_text
from plymotion.solver.studies.design import trials as design_trials
from plymotion.solver.studies.design.study_state import FILE
from plymotion.solver.studies.design.trials import StudySpec, Trials
from tests.samples.design_samples import BEST, CARBON, F_MAX, V0, M, angles, oscillator, swung, tube
from tests.samples.exchange_routes import PROGRAMS
from tests.samples.package_samples import cantilever


def _case(table: dict[str, Any], name: str = "case") -> pm.Case:
    found = pm.Case(name)
    found.table = copy.deepcopy(table)
    return found


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("driver", ["slsqp", "trust-constr"])
def test_spring_of_the_shortest_way_within_a_force(driver: str) -> None:
    """x = v0 sqrt(m / k) falls and F = v0 sqrt(m k) rises with k: the best k is at the limit."""
    found = pm.optimise(_case(oscillator(driver=driver, iterations=40)))
    assert found.parameters["k"] == pytest.approx(BEST, rel=2e-3)  # F to 1e-3, k as its square
    (way, force) = found.data["optimum"]["shown"]
    assert way == pytest.approx(V0 * np.sqrt(M / BEST), rel=1e-3)
    assert force == pytest.approx(-F_MAX / M, rel=1e-3)
    assert found.data["optimum"]["violation"] < 1e-4
    page = (found.folder / "design.html").read_text("utf-8")
    assert "<title>Ball on a spring: stop</title>" in page
    assert ">k [N/m]<" in page
    strong = re.findall("<polyline (.*?)/>", page)[1::2]
    for start, line in zip(found.data["starts"], strong, strict=True):
        valid = sum(point["violation"] <= 1e-3 for point in start["history"])
        assert line.count(",") == valid + 1  # the last one twice


def test_front_of_way_and_force(monkeypatch: pytest.MonkeyPatch) -> None:
    """x = v0 sqrt(m / k), F = v0 sqrt(m k): all stiffnesses have x F = m v0^2, none is better."""
    monkeypatch.syspath_prepend(str(PROGRAMS / "optimisers"))
    pytest.importorskip("pymoo")
    second = {"signal": "a", "of": "min"}
    study = {"driver": "genetic", "front": second, "iterations": 4, "starts": 1, "subject_to": []}
    found = pm.optimise(_case(oscillator(**study)))
    ways, accelerations = np.array([point["shown"] for point in found.front]).T
    assert len(ways) > 20
    np.testing.assert_allclose(-ways * accelerations, V0**2, rtol=3e-3)
    assert (np.diff(ways) > 0.0).all()
    assert (np.diff(accelerations) > 0.0).all()
    page = (found.folder / "design.html").read_text("utf-8")
    assert page.count("<circle") == len(ways)
    with pytest.raises(InputError, match=r'driver = "slsqp": expected "genetic" with `front`'):
        _case(oscillator(front=second)).check()


def test_component_of_openmdao(monkeypatch: pytest.MonkeyPatch) -> None:
    """Values and derivatives of the closed form; OpenMDAO's own check of partials."""
    monkeypatch.syspath_prepend(str(PROGRAMS / "optimisers"))
    om = pytest.importorskip("openmdao.api")
    monkeypatch.setenv("OPENMDAO_REPORTS", "0")
    table = oscillator(rtol=1e-10)
    table["solver"] |= {"rtol": 1e-10, "output_step": 0.001}
    problem = om.Problem(reports=False)
    problem.model.add_subsystem("study", pm.openmdao_component(_case(table)), promotes=["*"])
    problem.setup()
    k = 140.0
    problem.set_val("k", k)
    problem.run_model()
    x = V0 * np.sqrt(M / k)
    assert problem.get_val("signal_x_max")[0] == pytest.approx(x, rel=1e-6)
    rates = problem.compute_totals(of=["signal_x_max", "signal_a_min"], wrt=["k"])
    assert rates["signal_x_max", "k"][0, 0] == pytest.approx(-x / (2.0 * k), rel=1e-5)
    checked = problem.check_partials(out_stream=None, method="fd", form="central", step=0.1)
    for each in checked["study"].values():
        assert np.abs(each["J_fwd"] - each["J_fd"]).max() < 1e-5 * np.abs(each["J_fd"]).max()


def test_packages_of_the_case_keep_their_own_derivatives(tmp_path: Path) -> None:
    """One by a parameter that happens to have the name of one of the study changes no design."""
    package = cantilever()
    rate = Derivative("k", "number", (), {"modes/frequencies": package.frequencies})
    write_package(tmp_path / "arm.vtkhdf", replace(package, design=(rate,)))
    table = oscillator(maximise={"frequency": "arm"}, subject_to=[])
    del table["design"]["studies"]["stop"]["minimise"]
    table["bodies"]["arm"] = {"kind": "package", "package": "arm.vtkhdf"}
    table["joints"]["clamp"] = {"kind": "fixed", "between": ["ground.zero", "arm.root"]}
    given = StudySpec(table, tmp_path / "case.toml", False, "stop", tmp_path, exact=True)
    assert Trials(given).slopes(np.array([100.0])) == [[[0.0]]]


def test_slope_of_a_peak_is_that_of_the_closed_form() -> None:
    found = pm.optimise(_case(oscillator(starts=1, iterations=3)))
    # The start has k = 100: d(v0 sqrt(m / k)) / dk = -x / (2 k).
    x = V0 * np.sqrt(M / 100.0)
    (slope,) = found.data["sensitivities"]["start"][0]
    assert slope == pytest.approx(-x / 200.0, rel=2e-4)


def test_invalid_designs_are_a_barrier() -> None:
    """Beyond a stiffness of 250 N/m the damping is negative and refused; the best is near it."""
    table = oscillator(starts=1, subject_to=[], iterations=6)
    table["design"]["parameters"]["k"]["of"].append(
        {"key": "forces.buffer.damping", "factor": -0.004, "offset": 1.0}
    )
    found = pm.optimise(_case(table))
    start = found.data["starts"][0]
    assert start["invalid"]
    assert "forces.buffer.damping" in start["invalid"][0]
    assert 200.0 < found.parameters["k"] <= 250.0


def test_study_goes_on_where_it_was_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    from plymotion.solver.studies.design import trials

    whole = pm.optimise(_case(oscillator(starts=1)), out="whole")
    total = whole.data["starts"][0]["computed"]
    assert total > 4
    real, left = trials.Trials.values, [4]  # the first one asks for exact derivatives

    def stopped(self: Any, p: Any) -> Any:
        if not left[0]:
            signal.raise_signal(signal.SIGTERM)
            raise KeyboardInterrupt  # where another thread gets it
        left[0] -= 1
        return real(self, p)

    with monkeypatch.context() as patch:
        patch.setattr(trials.Trials, "values", stopped)
        Path("ball.toml").write_text(toml_text(oscillator(starts=1)), "utf-8")
        command = ["optimise", "ball.toml", "--study=stop", "--out=part", "--quiet"]
        assert main(command) == 128 + signal.SIGTERM
    file = Path("part/studies/stop") / FILE
    with file.open("ab") as torn:
        torn.write(b'0123456789abcdef {"kind": "val')  # a line that the signal cut
    for computed in (total - 3, 0):
        assert main(command) == 0
        rest = json.loads(file.with_name("design.json").read_text("utf-8"))
        assert rest["starts"][0]["computed"] == computed
        assert rest["optimum"] == whole.data["optimum"]


def test_another_case_computes_its_designs_again() -> None:
    first = pm.optimise(_case(oscillator(starts=1)), out="same")
    table = oscillator(starts=1)
    table["bodies"]["ball"]["mass"] = 2.0 * M
    second = pm.optimise(_case(table), out="same")
    assert second.data["starts"][0]["computed"] > 0
    assert second.data["inputs_sha256"] != first.data["inputs_sha256"]


def test_discrete_values() -> None:
    """Of the allowed stiffnesses the largest one that the force allows is best."""
    table = oscillator(iterations=3)
    table["design"]["parameters"]["k"]["step"] = 70.0
    found = pm.optimise(_case(table), jobs=2)
    assert found.parameters["k"] == 70.0 * (BEST // 70.0)


def test_names_are_chosen_as_all_of_them_say(fenicsx: str, tmp_path: Path) -> None:
    """Materials of two plies: the lightest wall that is stiff enough, among all four."""
    study = {"run": "base", "minimise": {"mass": "arm"}, "starts": 1, "verify": False}
    study["subject_to"] = [{"section": "arm", "entry": "K11", "min": 4e6}]
    key = "sections.tube:laminates.wall.plies.{}.material"
    own = {"kind": "choice", "set": ["carbon", "glass"]}
    choices = {f"m{k}": {"of": [key.format(k)], **own} for k in range(2)}
    table = tube(parameters=choices, studies={"s": study})
    light = {"E1": 40e9, "E2": 9e9, "E3": 9e9, "G12": 4e9, "G13": 4e9, "G23": 3e9, "rho": 1200.0}
    table["materials"]["glass"] = CARBON | light
    found = pm.optimise(_case(table))
    trials = Trials(StudySpec(table, Path("t.toml"), False, "s", tmp_path))
    every = {(i, j): trials.values(np.array([i, j])).shown for i in range(2) for j in range(2)}
    mass, best = min((m, key) for key, (m, K11) in every.items() if K11 >= 4e6)
    assert found.data["optimum"]["shown"][0] == mass
    assert [*found.parameters.values()] == [own["set"][k] for k in best]
    assert len({*best}) == 2  # neither the start nor the lightest of all
    found.changed(_case(table)).check()
    text = (found.folder / "optimum.toml").read_text("utf-8")
    assert f'"laminates.wall.plies.0.material" = {found.parameters["m0"]!r}' in text
    assert found.parameters["m1"] in repr(found)


def test_best_design_as_variant_and_as_case() -> None:
    table = oscillator(starts=1)
    found = pm.optimise(_case(table))
    text = (found.folder / "optimum.toml").read_text("utf-8")
    assert f"[variants.stop.forces.buffer]\nstiffness = {found.parameters['k']!r}" in text
    best = pm.run(found.changed(_case(table)), out="best")
    between = found.data["optimum"]["shown"][0]  # of the parabola between outputs
    assert 0.998 * between < best.signals["x"].max <= between
    assert json.loads((found.folder / "design.json").read_text())["study"] == "stop"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"of": ["forces.bufer.stiffness"]}, "did you mean 'buffer'"),
        ({"of": ["solver.max_step"]}, "solver.max_step is absent in this run; expected `start`"),
        ({"kind": "angle"}, 'has the unit "N/m"; expected deg'),
        ({"bounds": [900.0, 50.0]}, "expected the lower bound first"),
        ({"bounds": [200.0, 900.0]}, "the case has 100, outside 200 to 900"),
        ({"kind": "choice"}, "expected `set`"),
        ({"kind": "choice", "set": ["a", "b"], "bounds": None}, "key of a text, this is a number"),
        ({"set": ["a", "b"], "bounds": None}, 'expected names of kind = "choice"'),
        ({"bounds": None}, "expected `bounds` or `set`"),
        ({"step": 2000.0}, "two multiples within the bounds"),
    ],
)
def test_mistakes_in_parameters(change: dict[str, Any], words: str) -> None:
    table = oscillator()
    table["design"]["parameters"]["k"] |= change
    if "bounds" in change and change["bounds"] is None:
        del table["design"]["parameters"]["k"]["bounds"]
    with pytest.raises(InputError, match=r"design\.parameters\.k") as error:
        _case(table).check()
    assert words in str(error.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"run": "bse"}, "did you mean 'base'"),
        ({"minimise": {"signal": "y", "of": "max"}}, "no such signal"),
        ({"minimise": {"signal": "x"}}, "expected a key `of`"),
        ({"minimise": {"frequency": "ball", "mode": 2}}, "cannot be chosen by its number"),
        ({"minimise": {"mass": "bal"}}, "did you mean 'ball'"),
        ({"minimise": {"signal": "x", "of": "min"}}, "expected under `maximise`"),
        ({"maximise": {"mass": "ball"}}, "either `minimise` or `maximise`"),
        ({"minimise": {"strength": "ball"}}, "expected under `maximise`"),
        ({"subject_to": [{"frequency": "ball", "min": 1.0}]}, "is rigid in this run"),
        ({"subject_to": [{"signal": "x", "of": "max", "min": 1.0}]}, "expected no `min`"),
        ({"subject_to": [{"mass": "ball"}]}, "expected `min`, `max` or both"),
        ({"rules": [{"share": 0.1, "step": 45}]}, "or one of share, equal_plies, step"),
        ({"parameters": ["q"]}, "parameter of the design"),
    ],
)
def test_mistakes_in_studies(change: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=r"design\.studies\.stop") as error:
        _case(oscillator(**change)).check()
    assert words in str(error.value)


def test_unknown_driver_and_study() -> None:
    with pytest.raises(InputError, match=r'driver = "slqp".*did you mean \'slsqp\''):
        pm.optimise(_case(oscillator(driver="slqp")))
    with pytest.raises(InputError, match="did you mean 'stop'"):
        pm.optimise(_case(oscillator()), "stip")


def _coupling(theta: float) -> float:
    """S16 of a ply [1/Pa], whose sign is that of its twist under tension (Jones, 2.6)."""
    c, s = np.cos(theta), np.sin(theta)
    S11, S22, S66 = 1.0 / CARBON["E1"], 1.0 / CARBON["E2"], 1.0 / CARBON["G12"]
    S12 = -CARBON["nu12"] / CARBON["E1"]
    return float(
        (2.0 * S11 - 2.0 * S12 - S66) * s * c**3 - (2.0 * S22 - 2.0 * S12 - S66) * s**3 * c
    )


def test_tube_that_twists_most_under_tension(fenicsx: str) -> None:
    """A thin tube of one angle: F makes the twist S16 F / (2 pi R^2 t), largest at 33.5 deg."""
    study = {
        "run": "base",
        "maximise": {"section": "arm", "entry": "S14"},
        "starts": 2,
        "verify": False,
        "gradient": "exact",
    }
    one = {"a": angles(1)["p0"]}
    one["a"]["of"].append("sections.tube:laminates.wall.plies.1.angle_deg")
    found = pm.optimise(_case(tube(parameters=one, studies={"twist": study})))
    assert found.data["gradient"].startswith("exact")
    best = minimize_scalar(lambda t: _coupling(t), bounds=(0.1, 1.4), method="bounded")
    R, t = 0.025 - 0.25e-3, 0.5e-3
    twist = -float(best.fun) / (2.0 * np.pi * R**2 * t)
    # The wall has 1 % of the radius: angle and twist to that given.
    assert found.parameters["a"] == pytest.approx(np.degrees(best.x), abs=0.7)
    assert found.data["optimum"]["shown"][0] == pytest.approx(twist, rel=0.02)
    ends = [start["best"]["p"][0] for start in found.data["starts"]]
    assert ends == pytest.approx([found.parameters["a"]] * 2, abs=0.1)


def test_gradient_of_a_run_is_that_of_rebuilt_designs(fenicsx: str, tmp_path: Path) -> None:
    """Tangent along derivatives of packages, against four designs beside for each parameter."""
    study = {
        "run": "base",
        "minimise": {"signal": "error", "of": "rms"},
        "subject_to": [
            {"strength": "arm", "min": 1.5},
            {"deformation_energy": "arm", "of": "at", "time": 0.03, "max": 1.0},
            {"section": "arm", "entry": "S14", "max": 1.0},
            {"frequency": "mechanism", "min": 1.0},
        ],
        "rtol": 1e-9,
    }
    load = {"of": ["masses.load.mass"], "kind": "number", "bounds": [0.5, 2.0]}
    wall = {
        "of": [f"sections.tube:laminates.wall.plies.{i}.thickness" for i in range(2)],
        "kind": "thickness",
        "bounds": [0.1e-3, 0.5e-3],
    }
    parameters = {"p0": angles(1)["p0"], "load": load, "wall": wall}
    table = swung(parameters=parameters, studies={"s": study})
    # A ply alone: where both are equally thick, the mesh has two rows of cells, else three.
    alone = {"p0": parameters["p0"], "wall": {**wall, "of": wall["of"][:1]}}
    uneven = swung(parameters=alone, studies={"s": study})
    why = Trials(StudySpec(uneven, Path("tube.toml"), False, "s", tmp_path)).why_not_exact()
    assert "parameter wall, body arm: changes the model, not only its numbers" in why
    given = StudySpec(table, Path("tube.toml"), False, "s", tmp_path)
    exact, p = Trials(replace(given, exact=True)), np.array([31.0, 1.0, 0.25e-3])
    values, found = exact.values(p), exact.slopes(p)
    assert not values.why
    assert "tangent" in exact.words_of_gradient()
    assert not exact.values(
        np.array([90.0, 2.0, 0.5e-3])
    ).why  # at bounds that the case may not pass
    exact.values(p)
    # Packages without derivatives keep 21 bits of the strains of recovery (5e-7).
    plain = Trials(given)
    for one, other in zip(plain.values(p).values, values.values, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6)
    # A larger change of the angle moves the point of a ply that governs, of the mass a peak.
    for k, (rebuilt, h) in enumerate(((exact, 0.1), (plain, 2e-4), (exact, 2e-8))):
        at = [rebuilt.values(p + i * h * np.eye(3)[k]).values for i in (-2, -1, 1, 2)]
        for m, slopes in enumerate(found):
            far, near, next_, further = (np.array(v[m]) for v in at)
            expected = (8.0 * (next_ - near) - (further - far)) / (12.0 * h)
            size = np.abs(np.array(slopes)[:, k]).max()
            near_by = (1e-6, 1e-6, 1e-6, 1e-7, 1e-6)[m] * size
            np.testing.assert_allclose(np.array(slopes)[:, k], expected, rtol=0.0, atol=near_by)


Z_RMS, STRENGTH = {"signal": "z", "of": "rms"}, {"strength": "arm", "min": 0.1}
KINDS = {
    "motion": [Z_RMS],
    "stiffening": [Z_RMS],
    "stresses": [Z_RMS, STRENGTH, {**Z_RMS, "signal": "exposures", "max": 9.0}],
    "stresses by the adjoint": [Z_RMS, STRENGTH],
}


@pytest.mark.parametrize("kind", KINDS)
def test_angles_that_change_a_section_in_fewer_ways(
    kind: str, fenicsx: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A study follows some of its angles; their slopes add up to that of one that turns all."""
    monkeypatch.setattr(design_trials, "MANY", 5 if "adjoint" in kind else 100)
    table, plies, every = swung(10), np.linspace(-60.0, 70.0, 10), angles(10)
    table["signals"] |= {
        "exposure": {"kind": "exposure", "body": "arm"},
        "exposures": {"kind": "difference", "of": "exposure", "run": "heavy"},
    }
    table["runs"]["heavy"] = {"variants": ["heavy"]}
    table["variants"]["heavy"] = {"masses": {"load": {"mass": 1.5}}}
    table["solver"] |= {"geometric_stiffening": kind == "stiffening", "rtol": 1e-8}
    load = {"of": ["masses.load.mass"], "kind": "number", "bounds": [0.5, 2.0]}
    of = [{"key": p["of"][0], "offset": a} for p, a in zip(every.values(), plies, strict=True)]
    turn = {"of": of, "kind": "angle", "bounds": [-20.0, 20.0], "start": 0.0}
    minimise, *subject_to = KINDS[kind]
    study = {"run": "base", "minimise": minimise, "subject_to": subject_to, "rtol": 1e-8}
    found, ways = [], []
    for parameters, p in (({"load": load, **every}, plies), ({"load": load, "turn": turn}, [0.0])):
        table["design"] = {"parameters": parameters, "studies": {"s": study}}
        trials = Trials(StudySpec(table, Path("tube.toml"), False, "s", tmp_path, exact=True))
        found.append(trials.slopes(np.array([1.0, *p])))
        ways.append(len(trials._beside["base"]))
    assert ways[0] < 11
    for slopes, common in zip(*found, strict=True):
        slopes, common = np.array(slopes), np.array(common)
        near_by = 1e-6 * np.abs(slopes[:, 1:]).max()
        np.testing.assert_allclose(slopes[:, 0], common[:, 0], rtol=1e-6)
        np.testing.assert_allclose(slopes[:, 1:].sum(axis=1), common[:, 1], rtol=0, atol=near_by)


def test_sensitivities_by_all_parameters_of_a_design(fenicsx: str) -> None:
    """Without keys: the angle of a ply and a mass; the angle against two packages beside."""
    load = {"of": ["masses.load.mass"], "kind": "number", "bounds": [0.5, 2.0]}
    table = swung(parameters={"p0": angles(1)["p0"], "load": load})
    found = pm.sensitivities(_case(table), "base")
    assert found.parameters == {"p0": 20.0, "load": 1.0}
    own, h, ends = found.derivatives["z"], 0.05, []
    plies = table["sections"]["tube"]["description"]["laminates"]["wall"]["plies"]
    for angle in (20.0 - h, 20.0 + h):
        plies[0]["angle_deg"] = angle
        ends.append(pm.run(_case(table, f"at_{angle}"), "base").signals["z"].values)
    expected = (ends[1] - ends[0]) / (2.0 * h)
    size = np.abs(expected).max()
    assert size > 1e-6
    np.testing.assert_allclose(own["p0"], expected, rtol=0.0, atol=1e-5 * size)
    plies[0]["angle_deg"] = 20.0
    direct = pm.sensitivities(_case(table), "base", of=["masses.load.mass"]).derivatives["z"]
    size = np.abs(own["load"]).max()
    np.testing.assert_allclose(own["load"], direct["masses.load.mass"], rtol=0.0, atol=1e-6 * size)
    mean = {"signal": "z", "of": "rms"}
    by_adjoint = pm.sensitivities(_case(table), "base", of=["p0"], objective=mean).gradient["p0"]
    z = found.signals["z"].values
    weights = np.r_[0.5, np.ones(z.size - 2), 0.5]
    slope = (weights * z * own["p0"]).sum() / np.sqrt((weights * z**2).sum() * weights.sum())
    assert by_adjoint == pytest.approx(slope, rel=1e-7)


@pytest.mark.parametrize(
    ("keys", "objective", "words"),
    [
        (["k", "k"], None, "--of k: given twice"),
        (["kk"], None, "has derivatives by it .*did you mean 'k'"),
        (["k"], {"signal": "far", "of": "rms"}, "objective: signal far reads another run"),
    ],
)
def test_mistakes_in_sensitivities(
    keys: list[str], objective: dict[str, Any] | None, words: str
) -> None:
    table = oscillator()
    table["runs"]["other"] = {}
    table["signals"]["far"] = {"kind": "difference", "of": "x", "run": "other"}
    with pytest.raises(InputError, match=re.escape(words).replace(r"\.\*", ".*")):
        pm.sensitivities(_case(table), "base", of=keys, objective=objective)


def test_packages_without_derivatives_have_differences(
    fenicsx: str, caplog: pytest.LogCaptureFixture
) -> None:
    """Half of a pair of modes turns with the angle of one ply: the design is valid all the same."""
    study = {"run": "base", "maximise": {"section": "arm", "entry": "K14"}, "verify": False}
    table = tube(4, parameters=angles(4), studies={"f": study})
    given = StudySpec(table, Path("t.toml"), False, "f", Path("f"), exact=True)
    at = np.zeros(4)
    exact, plain = Trials(given), Trials(replace(given, exact=False))
    assert not exact.values(at).why
    assert exact.slopes(at) == plain.slopes(at)
    assert "couples a selected mode with one of the same frequency" in caplog.text


def test_run_without_a_tangent() -> None:
    """Another integrator has differences; `exact` is refused by name."""
    table = oscillator(starts=1, iterations=1)
    table["solver"]["integrator"] = "rk8"
    found = pm.optimise(_case(table))
    assert found.data["gradient"].startswith("central differences")
    table["design"]["studies"]["stop"]["gradient"] = "exact"
    with pytest.raises(InputError, match=r'"exact".*solver\.integrator = "rk8"'):
        pm.optimise(_case(table))


def test_plan_that_makes_the_designed_body_rigid_is_refused(fenicsx: str) -> None:
    """An accuracy so coarse that the tube may be rigid: the tip would not depend on its plies."""
    study = {"run": "base", "minimise": {"signal": "z", "of": "rms"}, "starts": 1}
    table = swung(parameters=angles(1), studies={"s": study})
    table["signals"].pop("error")
    table["fidelity"] = {"accuracy": 0.9}
    with pytest.raises(InputError, match=r"accuracy = 0\.9 makes the designed body arm rigid"):
        pm.optimise(_case(table))
    assert not list(Path().rglob("design.json"))
