"""Parts of studies: values with their derivatives, rules of lay-ups, optimisers, saddles."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.design import CheckedStudy
from plymotion.solver.inputs.case.load import checked_case
from plymotion.solver.inputs.case.tables.design_keys import Quantity
from plymotion.solver.math.arrays import Array
from plymotion.solver.studies.design.design_text import outcome_lines
from plymotion.solver.studies.design.drivers.table import DRIVERS
from plymotion.solver.studies.design.measures import Mass, Measure, measure_of
from plymotion.solver.studies.design.problem import Options, Problem, Values
from plymotion.solver.studies.design.rules import broken, space_of
from plymotion.solver.studies.design.starts import Start, first_points, search
from tests.samples.design_samples import CARBON, STRENGTH, angles, tube
from tests.samples.exchange_routes import PROGRAMS

T = np.linspace(0.0, 2.0, 81)
OPTIMISERS = str(PROGRAMS / "optimisers")  # those of make exchange-programs


def _measure(**keys: Any) -> Measure:
    return measure_of(Quantity.model_validate(keys))


def _signal(a: float) -> Array:
    return np.asarray(np.exp(-0.4 * T) * np.sin((3.0 + a) * T + a) + 0.3 * a * T)


def _eigenvalues(a: float) -> Array:
    """Two that meet at a = 0, as those of a round section, and a third."""
    return np.sort([4.0e4 + 3.0e3 * a, 4.0e4 - 3.0e3 * a, 5.0e5])


def _stiffness(a: float) -> Array:
    root = np.eye(6) + 0.1 * np.cos(np.arange(36.0).reshape(6, 6) * (1.0 + 0.1 * a))
    return np.asarray(root @ root.T)


@pytest.mark.parametrize(
    ("keys", "raw"),
    [
        ({"signal": "s", "of": "max"}, _signal),
        ({"signal": "s", "of": "min", "from": 0.5}, _signal),
        ({"signal": "s", "of": "rms", "to": 1.5}, _signal),
        ({"signal": "s", "of": "at", "time": 1.23}, _signal),
        ({"strength": "b"}, lambda a: np.abs(np.array([_signal(a), 0.7 * _signal(a + 0.1)]))),
        ({"frequency": "b"}, lambda a: _eigenvalues(a + 0.3)),
        ({"section": "b", "entry": "K24"}, _stiffness),
        ({"section": "b", "entry": "S14"}, _stiffness),
    ],
)
def test_weights_are_derivatives_of_the_values(keys: dict[str, Any], raw: Any) -> None:
    measure, h = _measure(**keys), 1e-5
    assert measure.quantity.words().endswith(" 1.23 s") == ("time" in keys)
    _, weights = measure.reduce(raw(0.2), T)
    rate = (raw(0.2 + h) - raw(0.2 - h)) / (2.0 * h)
    slope = np.tensordot(weights, rate, axes=rate.ndim)
    up, down = (measure.reduce(raw(0.2 + s), T)[0] for s in (h, -h))
    assert slope == pytest.approx((up - down) / (2.0 * h), rel=1e-6, abs=1e-6 * np.abs(slope).max())


def test_lowest_of_two_equal_frequencies_has_a_derivative() -> None:
    """They cross with slopes of opposite sign: the lowest has a kink, the value has none."""
    measure = _measure(frequency="b")
    value, weights = measure.reduce(_eigenvalues(0.0), T)
    assert value[0] == pytest.approx(200.0 / (2.0 * np.pi), rel=2e-3)
    assert value[0] < measure.shown(_eigenvalues(0.0), T)
    rate = np.array([3.0e3, -3.0e3, 0.0])
    assert abs(weights[0] @ rate) < 1e-9 * np.abs(weights[0]).max() * 3.0e3


def test_peaks_between_outputs() -> None:
    found, _ = _measure(signal="s", of="max").reduce(np.sin(7.0 * T), T)
    assert found[:2] == pytest.approx([1.0, 1.0], abs=1e-4)  # outputs alone: 4e-3


def _study(plies: int, parameters: dict[str, Any], **study: Any) -> CheckedStudy:
    own = {"run": "base", "maximise": {"frequency": "arm"}, **study}
    table = tube(plies, parameters=parameters, studies={"s": own})
    return checked_case(table, Path("tube.toml")).studies["s"]


def test_symmetric_and_balanced_plies_follow_one_angle() -> None:
    space = space_of(_study(4, angles(4), rules=["symmetric", "balanced"]))
    assert space.names == ("p0",)
    assert space.p(np.array([30.0])) == pytest.approx([30.0, -30.0, -30.0, 30.0])


def test_balanced_needs_a_partner() -> None:
    with pytest.raises(InputError, match=r"ply 2 of arm\.wall has no partner"):
        space_of(_study(3, angles(3), rules=["balanced"]))
    one = {"a": angles(1)["p0"]}
    key = "sections.tube:laminates.wall.plies.1.angle_deg"
    one["a"]["of"].append({"key": key, "factor": -1.0})
    assert space_of(_study(2, one, rules=["balanced"])).names == ("a",)


def test_angle_between_neighbours_is_a_linear_limit() -> None:
    space = space_of(_study(2, angles(2), rules=[{"step": 45}]))
    for p, kept in (([10.0, 50.0], True), ([10.0, 60.0], False), ([60.0, 10.0], False)):
        assert (space.A @ np.array(p) <= space.b + 1e-9).all() == kept


def test_rules_of_discrete_lay_ups() -> None:
    rules = [{"share": 0.1}, {"equal_plies": 2}, {"step": 45}]
    study = _study(6, angles(6, step=45.0), rules=rules)
    assert not broken(study, np.array([45.0, 0.0, -45.0, 90.0, 45.0, 0.0]))
    assert not broken(study, np.array([45.0, 90.0, -45.0, -45.0, 0.0, 0.0]))  # 90 to -45: 45
    (line,) = broken(study, np.array([0.0, 45.0, 90.0, 90.0, 90.0, -45.0]))
    assert "3 equal plies" in line
    assert "share 0 at -45 deg" in broken(study, np.array([0.0, 45.0, 90.0, 45.0, 0.0, 0.0]))[0]
    with pytest.raises(InputError, match="expected `set` or `step` of parameter p0"):
        space_of(_study(2, angles(2), rules=[{"share": 0.1}]))


RATIO = 1.2  # length over width of the plate


def _plate(theta: float) -> float:
    """f / f0 of a simply supported plate of many plies [theta, -theta], specially orthotropic.

    (f / f0)^2 = D11 + 2 (D12 + 2 D66) R^2 + D22 R^4 of Q turned (Jones, Mechanics of Composite
    Materials, 5.4), lowest mode.
    """
    E1, E2, G, nu = (CARBON[k] for k in ("E1", "E2", "G12", "nu12"))
    Q11, Q22 = E1 / (1 - nu**2 * E2 / E1), E2 / (1 - nu**2 * E2 / E1)
    Q12, Q66, c, s = nu * Q22, G, np.cos(theta), np.sin(theta)
    D11 = Q11 * c**4 + 2 * (Q12 + 2 * Q66) * s**2 * c**2 + Q22 * s**4
    D22 = Q11 * s**4 + 2 * (Q12 + 2 * Q66) * s**2 * c**2 + Q22 * c**4
    both = (Q11 + Q22 - 4 * Q66) * s**2 * c**2 + Q12 * (s**4 + c**4)
    both += 2 * ((Q11 + Q22 - 2 * Q12 - 2 * Q66) * s**2 * c**2 + Q66 * (s**4 + c**4))
    return float(np.sqrt((D11 + 2 * both * RATIO**2 + D22 * RATIO**4) / E1))


class _Plates:
    """Designs whose frequency has a closed form; derivatives by the complex step of one part."""

    def values(self, p: Array) -> Values:
        f = _plate(np.radians(p[0]))
        return Values("", [[f]], [f], [""])

    def slopes(self, p: Array) -> list[list[list[float]]]:
        up, down = (_plate(np.radians(p[0] + h)) for h in (1e-4, -1e-4))
        return [[[(up - down) / 2e-4]]]


def _problem(study: CheckedStudy, z: Array) -> Problem:
    return Problem(_Plates(), study.table, [Mass(study.table.objective)], space_of(study), z)


def _best() -> float:
    scan = np.linspace(0.0, 90.0, 90_001)
    return float(scan[np.argmax([_plate(t) for t in np.radians(scan)])])


@pytest.mark.parametrize("driver", sorted(DRIVERS))
def test_plate_of_plus_and_minus_theta(driver: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(OPTIMISERS)
    study = _study(1, angles(1), driver=driver)
    problem = _problem(study, np.array([30.0]))
    try:
        DRIVERS[driver].minimise(problem, Options(100, 1e-9, 0))
    except InputError as error:
        pytest.skip(str(error))  # an extra that is not installed
    assert problem.best is not None
    assert abs(problem.best.p[0]) == pytest.approx(_best(), abs=0.1)


@pytest.mark.parametrize("first", [0.0, 90.0, -90.0])
def test_start_at_a_saddle_leaves_it(first: float) -> None:
    """At 0 and 90 deg the derivative is zero by symmetry, and the frequency is not the best."""
    study, start = _study(1, angles(1)), Start(0)
    search(start, study, lambda z: _problem(study, z), np.array([first]))
    assert start.left_saddle
    assert start.best is not None
    assert abs(start.best.p[0]) == pytest.approx(_best(), abs=0.2)


def test_nearest_allowed_angles_are_compared() -> None:
    study, start = _study(1, angles(1, set=[0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0])), Start(0)
    search(start, study, lambda z: _problem(study, z), np.array([20.0]))
    allowed = np.arange(0.0, 91.0, 15.0)
    assert start.best is not None
    assert start.best.p[0] == allowed[np.argmax([_plate(t) for t in np.radians(allowed)])]


class _Pitted(_Plates):
    """Designs of two angles: a flat top at zero, and a better one that has no good neighbours."""

    def values(self, p: Array) -> Values:
        f = 2.0 if p.tolist() == [60.0, -60.0] else float(1.0 / (1.0 + np.abs(p).sum()))
        return Values("", [[f]], [f], [""])

    def slopes(self, p: Array) -> list[list[list[float]]]:
        return [[[0.0, 0.0]]]


@pytest.mark.parametrize("step", [30.0, 10.0])
def test_few_allowed_designs_are_all_compared(step: float) -> None:
    """Of 49, the search for better neighbours ends at (0, 0); of 361 it is all there is."""
    study, start = _study(2, angles(2, step=step)), Start(0)
    space, first = [Mass(study.table.objective)], np.array([10.0, 10.0])
    problem = Problem(_Pitted(), study.table, space, space_of(study), first)
    search(start, study, lambda z: problem, first)
    assert start.best is not None
    assert start.best.p == ([60.0, -60.0] if step == 30.0 else [0.0, 0.0])


class _Ordered(_Plates):
    """Designs of four angles: best where they descend, otherwise better the more they ascend."""

    def values(self, p: Array) -> Values:
        f = 9.0 if p.tolist() == [90.0, 45.0, 0.0, -45.0] else float((np.arange(4) @ p) / 1e3)
        return Values("", [[f]], [f], [""])

    def slopes(self, p: Array) -> list[list[list[float]]]:
        return [[[0.0] * 4]]


def test_designs_that_follow_the_rules_are_all_compared() -> None:
    """Of 625, 48 have a ply in each direction; a change of one ply leaves them."""
    study, start = _study(4, angles(4, step=45.0), rules=[{"share": 0.1}]), Start(0)
    space, first = [Mass(study.table.objective)], np.array([0.0, 0.0, 0.0, 0.0])
    problem = Problem(_Ordered(), study.table, space, space_of(study), first)
    search(start, study, lambda z: problem, first)
    assert start.best is not None
    assert start.best.p == [90.0, 45.0, 0.0, -45.0]


class _Valley(_Plates):
    """Designs of two angles: best at 37 and 37 deg, and elsewhere where both are equal."""

    def values(self, p: Array) -> Values:
        f = 2.0 - ((p[0] - 37.0) / 90.0) ** 2 - 9.0 * ((p[1] - p[0]) / 90.0) ** 2
        return Values("", [[f]], [f], [""])

    def slopes(self, p: Array) -> list[list[list[float]]]:
        along, across = -2.0 * (p[0] - 37.0) / 90.0**2, -18.0 * (p[1] - p[0]) / 90.0**2
        return [[[along - across, across]]]


def test_continuous_angles_follow_discrete_ones() -> None:
    step, free = angles(1, step=30.0), {"p1": angles(2)["p1"]}
    study, start = _study(2, step | free), Start(0)

    def problem(z: Array) -> Problem:
        return Problem(_Valley(), study.table, [Mass(study.table.objective)], space_of(study), z)

    search(start, study, problem, np.array([10.0, -10.0]))
    assert start.continuous is not None
    assert start.continuous.p == pytest.approx([37.0, 37.0], abs=0.1)
    assert start.best is not None
    assert start.best.p == pytest.approx([30.0, 30.0], abs=0.1)


class _Strong(_Plates):
    """Plies of six thicknesses; exposures of 40 plies of two bodies, of which 8 are known."""

    def __init__(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        self.loads = 6.0 * random.uniform(0.0, 1.0, (2, 40, 6)) ** 3
        self.phases = random.uniform(0.0, 6.0, (2, 40, 6))

    def _highest(self, body: int, p: Array) -> tuple[Array, Array]:
        loads, turn = self.loads[body], p / 8.0 + self.phases[body]
        share = 1.0 + 0.6 * np.sin(turn)
        exposures = (loads * share / p).sum(axis=1)
        rows = np.argsort(-exposures)[:8]
        slopes = loads * (0.6 / 8.0 * np.cos(turn) / p - share / p**2)
        return exposures[rows], slopes[rows]

    def values(self, p: Array) -> Values:
        found = [self._highest(body, p)[0] for body in (0, 1)]
        shown = [p.sum(), *(1.0 / each[0] for each in found)]
        return Values("", [[p.sum()], *(each.tolist() for each in found)], shown, ["kg", "", ""])

    def slopes(self, p: Array) -> list[list[list[float]]]:
        return [[[1.0] * p.size], *(self._highest(body, p)[1].tolist() for body in (0, 1))]


def test_a_start_beyond_its_limits_goes_back_to_them() -> None:
    """SLSQP alone ends 30 % beyond the limits, where designs within them exist."""
    least = [{"strength": "arm", "min": 1.5}, {"strength": "arm", "min": 2.0}]
    thick = {n: p | {"bounds": [0.2, 90.0]} for n, p in angles(6).items()}
    own = {"run": "base", "minimise": {"mass": "arm"}, "subject_to": least}
    table = tube(6, parameters=thick, studies={"s": own})
    table["materials"] = {"carbon": {**CARBON, "strength": STRENGTH}}
    study, start = checked_case(table, Path("tube.toml")).studies["s"], Start(0)
    measures = [measure_of(q) for q in study.table.quantities()]
    designs, space = _Strong(6), space_of(study)

    def problem(z: Array) -> Problem:
        return Problem(designs, study.table, measures, space, z)

    search(start, study, problem, np.full(6, 20.0))
    assert start.best is not None
    assert start.best.violation < 1e-4
    assert start.best.merit < 230.0


@pytest.mark.parametrize(
    ("segments", "asked", "words"),
    [
        (1, {"strength": "mechanism"}, "no such body; known: arm"),
        (2, {"strength": "arm"}, 'one segment, or a signal of kind "exposure"'),
        (2, {"frequency": "arm"}, 'one segment, or "mechanism"'),
    ],
)
def test_words_on_a_body_name_what_the_quantity_can_have(segments, asked, words) -> None:
    own = {"run": "base", "minimise": {"mass": "arm"}, "subject_to": [{**asked, "min": 1.0}]}
    table = tube(6, parameters=angles(6), studies={"s": own})
    table["bodies"]["arm"]["segments"] = segments
    with pytest.raises(InputError, match=words):
        checked_case(table, Path("tube.toml"))


def test_an_entry_that_symmetry_makes_zero_is_zero() -> None:
    """An optimiser would follow its rounding from design to design."""
    K = np.diag([1e7, 1e6, 1e6, 1e2, 1e3, 1e3])
    K[0, 3] = K[3, 0] = 3e-10 * np.sqrt(K[0, 0] * K[3, 3])
    for entry in ("K14", "S14"):
        values, weights = _measure(section="b", entry=entry).reduce(K, T)
        assert not values.any()
        assert weights[0, 0, 3]  # plies of 0 and 90 degrees that turn begin to couple
    K[0, 3] = K[3, 0] = 3e-9 * np.sqrt(K[0, 0] * K[3, 3])
    values, weights = _measure(section="b", entry="K14").reduce(K, T)
    assert values == K[0, 3]
    assert weights[0, 0, 3] == 1.0


def test_an_objective_that_depends_on_nothing_is_named() -> None:
    point = {"merit": 0.31, "violation": 0.0, "shown": [0.31], "p": [20.0], "values": {"a": 20.0}}
    study: dict[str, Any] = {
        "study": "light",
        "sense": "minimise",
        "measures": [{"words": "mass arm", "unit": "kg", "least": None, "most": None}],
        "parameters": {"a": {"unit": "deg", "names": [], "range": [-90.0, 90.0]}},
        "start": {"p": [20.0], "shown": [0.31]},
        "optimum": point,
        "sensitivities": {"start": [[0.0]], "optimum": [[0.0]]},
        "gradient": "exact",
        "starts": [{"best": point, "computed": 1, "history": [point], "invalid": []}],
    }
    text = "\n".join(outcome_lines(study, Path("build")))
    assert (
        "the objective was 0.31 for all designs, with derivatives of zero: does it depend" in text
    )
    # at a bound, one design is all that there is, with a derivative
    study["sensitivities"] = {"start": [[1e-9]], "optimum": [[1e-9]]}
    assert "does it depend" not in "\n".join(outcome_lines(study, Path("build")))


def test_rules_that_no_allowed_design_follows_are_named() -> None:
    study = _study(1, angles(1, set=[0.0, 20.0, 90.0]), rules=[{"share": 0.1}])
    start = Start(0)
    search(start, study, lambda z: _problem(study, z), np.array([20.0]))
    assert start.best is None
    assert "no design near it follows the rules: arm.wall: share 0 at" in start.message


def test_starts_begin_at_the_case_and_cover_the_bounds() -> None:
    study = _study(2, angles(2), starts=9)
    points = first_points(study, space_of(study))
    assert points[0] == pytest.approx([20.0, 20.0])
    assert len(points) == 9
    quarters = {(a > 0.0, b > 0.0) for a, b in points[1:]}
    assert len(quarters) == 4
    assert (points == first_points(study, space_of(study))).all()


def test_some_starts_have_one_direction_of_all_plies() -> None:
    """Independent angles have a mean near zero; stiffnesses of a laminate are such means."""
    study = _study(12, angles(12), starts=16)
    directions = np.cos(np.radians(2.0 * first_points(study, space_of(study)))).mean(axis=1)
    assert directions.min() < -0.8
    assert directions.max() > 0.8
