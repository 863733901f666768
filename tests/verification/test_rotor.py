"""The rotor in the wind against CCBlade, against momentum theory and against itself turned."""

import re

import numpy as np
import pytest
from samples.case_samples import computed_file
from samples.rotor_samples import HUB, RPM, TIP, ccblade, stations, write_rotor
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import curve_fit
from scipy.special import hankel2

from plymotion.solver.dynamics.analysis.recovery import Recording
from plymotion.solver.dynamics.evaluation.accelerations import derivative
from plymotion.solver.dynamics.evaluation.evaluation import evaluate
from plymotion.solver.dynamics.model.model import N_SECTION_STATE, QUASI, spare_workspace
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.tables.rotor import Polar
from plymotion.solver.mechanism import equilibrium
from plymotion.solver.mechanism.build import build
from plymotion.solver.mechanism.consistent import consistent_state
from plymotion.solver.mechanism.rotor import polar_rows
from plymotion.solver.run.preparation import prepare


class Steady:
    """A rotor in steady inflow: model, state, loads on its sections."""

    def __init__(self, file):
        built = build(load_case(file).runs["all"], {})
        self.model = built.model
        self.y = consistent_state(built.model, built.start, built.joint_names)
        self.recording = Recording(self.model, np.zeros(1), self.y[None])
        n = len(self.model.rotor.polar)
        elements = np.flatnonzero(self.model.rotor.section >= 0)
        assert len(elements) == n
        places = [2 * (self.model.joint_kind.size + int(k)) + 1 for k in elements]
        self.loads = self.recording.loads(places)[0]
        first = self.model.n_pos + self.model.n_vel + self.model.rotor.state
        count = n * N_SECTION_STATE
        self.states = self.y[first : first + count].reshape(n, N_SECTION_STATE)

    def of_first_blade(self):
        """Loads of the upright blade along and around the shaft (x) [N/m]."""
        width = stations()["width"]
        loads = self.loads[: len(width)]
        return loads[:, 0] / width, -loads[:, 1] / width


REFERENCE = "rotor_ccblade"


@pytest.mark.parametrize("k", range(5))
def test_loads_along_the_blade_are_those_of_ccblade(tmp_path, reference, k):
    point = reference["points"][k]
    wind = f"speed = {{ constant = {point['speed']} }}"
    found = Steady(write_rotor(tmp_path, wind, pitch=point["pitch"])).of_first_blade()
    for ours, key in zip(found, ("axial", "around"), strict=True):
        theirs = np.array(point[key])
        assert np.abs(ours - theirs).max() < reference["tolerance"] * np.abs(theirs).max()


def test_induction_by_the_polynomial_of_hawc2(tmp_path):
    """a = k1 c + k2 c^2 + k3 c^3 of the thrust coefficient over the loss, up to c = 1.2."""
    V, s = 5.0, stations()
    rotor = Steady(write_rotor(tmp_path, f"speed = {{ constant = {V} }}", induction="madsen"))
    axial, _ = rotor.of_first_blade()
    w_n, w_t = rotor.states[: len(axial), 2:4].T
    around = RPM * np.pi / 30.0 * s["r"] - w_t
    half = 1.5 * np.hypot(V + w_n, around) / (V + w_n)
    ends = (TIP - s["r"]) / s["r"], (s["r"] - HUB) / HUB
    loss = np.prod([2.0 / np.pi * np.arccos(np.exp(-half * gap)) for gap in ends], axis=0)
    c = 3.0 * axial / (np.pi * 1.225 * s["r"] * V**2) / loss
    assert c.max() > 1.2
    expected = 0.246 * c + 0.0586 * c**2 + 0.0883 * c**3
    np.testing.assert_allclose(-w_n / V, np.minimum(expected, 0.95), rtol=2e-3)


def test_the_reference_is_that_of_ccblade(reference):
    pytest.importorskip("wisdem.ccblade.ccblade")
    for point in reference["points"]:
        found = ccblade(point["speed"], point["pitch"])
        for key in ("axial", "around"):
            np.testing.assert_allclose(found[key], point[key], atol=2e-3)


def test_a_rotor_turned_with_its_wind_has_the_same_loads(tmp_path):
    """Also by `direction_deg`, which turns the wind only."""
    straight = Steady(write_rotor(tmp_path))
    wind = "speed = { constant = 10.0 }\ndirection_deg = 25.0"
    turned = Steady(write_rotor(tmp_path, wind, tilt=(0.0, 25.0)))
    c, s = np.cos(np.radians(25.0)), np.sin(np.radians(25.0))
    A = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    expected = np.concatenate([straight.loads[:, :3] @ A.T, straight.loads[:, 3:] @ A.T], axis=1)
    np.testing.assert_allclose(turned.loads, expected, atol=1e-6 * np.abs(expected).max())


def test_a_rotor_in_mm_has_the_same_loads(tmp_path):
    """Lengths of the case are in mm, those of its tables of strips in m."""
    file = write_rotor(tmp_path, "speed = { constant = 9.0 }\nshear_exponent = 0.2")
    loads = Steady(file).loads
    text = file.read_text().replace("[rotor.wind]", "[rotor.wind]\nreference_height = 1e5")
    text = re.sub(r"position = \[([^,]*),", lambda m: f"position = [{1e3 * float(m[1])!r},", text)
    file.write_text(f'units = "mm"\n{text}')
    np.testing.assert_allclose(Steady(file).loads, loads, rtol=1e-12, atol=1e-9)


def test_wind_grows_with_height_by_a_power_law(tmp_path):
    """A blade at 2.5 times the reference height has the load of 10 m/s times 2.5^0.2."""
    sheared = "speed = { constant = 10.0 }\nshear_exponent = 0.2\nreference_height = 4.0"
    plain = f"speed = {{ constant = {10.0 * (10.0 / 4.0) ** 0.2!r} }}"
    r = stations()["r"]
    one, two = (
        Steady(write_rotor(tmp_path, wind)).of_first_blade()[0] for wind in (sheared, plain)
    )
    assert np.interp(10.0, r, one) == pytest.approx(np.interp(10.0, r, two), rel=2e-3)


def test_induction_is_larger_where_the_skewed_wake_goes(tmp_path):
    """Pitt and Peters: with the wind to +y, blades at +y are in more induced velocity."""
    wind = "speed = { constant = 10.0 }\ndirection_deg = 20.0"
    skewed = Steady(write_rotor(tmp_path, wind))
    n = len(skewed.loads) // 3
    a = -skewed.states[:, 2].mean() / (10.0 * np.cos(np.radians(20.0)))
    marker = skewed.model.force_marker[skewed.model.rotor.section >= 0, 1]
    y = np.array([skewed.recording.position(int(k))[0, 1] for k in marker])
    angle = np.radians(20.0) * (1.0 + 0.6 * a)
    change = 15.0 * np.pi / 32.0 * np.tan(0.5 * angle) * np.ptp(y) / TIP
    assert 0.2 < change < 0.6
    # less axial flow, less thrust: the difference of the blades at both sides has this sign
    sides = [skewed.loads[i * n : (i + 1) * n, 0].sum() for i in (1, 2)]
    where = [y[i * n : (i + 1) * n].mean() for i in (1, 2)]
    straight = Steady(write_rotor(tmp_path, "speed = { constant = 10.0 }"))
    assert np.ptp([straight.loads[i * n : (i + 1) * n, 0].sum() for i in (1, 2)]) < 1e-6 * sides[0]
    assert (sides[0] - sides[1]) * (where[0] - where[1]) < 0.0


def test_a_step_of_pitch_passes_the_steady_load_and_returns(tmp_path):
    """Dynamic inflow: at first the wake is that of the old pitch; it goes with Oye's slow time."""
    steady = Steady(write_rotor(tmp_path))
    before = Steady(write_rotor(tmp_path, pitch=4.0))
    model, first = steady.model, steady.model.n_pos + steady.model.n_vel
    y = steady.y.copy()
    y[first:-1] = before.y[first:-1]
    t = np.linspace(0.0, 16.0, 321)
    found = solve_ivp(lambda t, y: derivative(model, t, y), (0.0, 16.0), y, "RK45", t, rtol=1e-5,
                      atol=1e-5)  # fmt: skip
    recording = Recording(model, t, np.ascontiguousarray(found.y.T))
    elements = np.flatnonzero(model.rotor.section >= 0)
    loads = recording.loads([2 * (model.joint_kind.size + int(k)) + 1 for k in elements])
    thrust, (new, old) = loads[:, :, 0].sum(axis=1), (s.loads[:, 0].sum() for s in (steady, before))
    over = (thrust - new) / (new - old)
    assert over[4] > 0.3  # once the stall has followed
    assert abs(over[-1]) < 0.2 * over[4]
    # One section by the equations as published, with the quasi-steady velocity of the run.
    work, states, quasi, k = spare_workspace(model), [], [], 9
    for i in range(len(t)):
        evaluate(model, work, t[i], np.ascontiguousarray(found.y[:, i]))
        quasi.append(work.flow[k, QUASI])
        states.append(found.y[first + model.rotor.state + N_SECTION_STATE * k + 2, i])
    forced, rate = CubicSpline(t, quasi), CubicSpline(t, quasi).derivative()
    share = np.hypot(*steady.recording.position(int(model.force_marker[k, 1]))[0, 1:]) / TIP

    def filtered(time, w):
        slow = 1.1 * TIP / (10.0 * (1.0 - 1.3 * min(-forced(time) / 10.0, 0.5)))
        fast = (0.39 - 0.26 * share**2) * slow
        return [(forced(time) + 0.6 * slow * rate(time) - w[0]) / slow, (w[0] - w[1]) / fast]

    stage = y[first + model.rotor.state + N_SECTION_STATE * k] + 0.6 * quasi[0]
    expected = solve_ivp(filtered, (0.0, 16.0), [stage, states[0]], "RK45", t, rtol=1e-6).y[1]
    assert np.ptp(expected) > 0.3
    np.testing.assert_allclose(states, expected, atol=0.01 * np.ptp(expected))


def thin(monkeypatch, share):
    """Make the blades of the sample thin, so that they do not slow the wind."""
    s = stations()
    chords = share * s["chord"]
    monkeypatch.setattr("samples.rotor_samples.stations", lambda: {**s, "chord": chords})
    return chords


def test_lift_in_a_changing_wind_is_that_of_theodorsen(tmp_path, monkeypatch):
    """The wind oscillates everywhere at once, as if the blade plunged: amplitude and phase C(k)."""
    chord, rate, r = thin(monkeypatch, 0.01), 4000.0, stations()["r"]
    low, high = (
        Steady(write_rotor(tmp_path, f"speed = {{ constant = {v} }}")) for v in (4.99, 5.01)
    )
    wind = f"speed = {{ expression = '5 + 0.01 * sin({rate} * t)' }}"
    model = (moving := Steady(write_rotor(tmp_path, wind))).model
    t = np.linspace(0.0, 0.08, 2001)
    found = solve_ivp(lambda t, y: derivative(model, t, y), (0.0, t[-1]), moving.y, "RK45", t,
                      rtol=1e-8, atol=1e-10)  # fmt: skip
    recording = Recording(model, t, np.ascontiguousarray(found.y.T))
    elements = np.flatnonzero(model.rotor.section >= 0)
    loads = recording.loads([2 * (model.joint_kind.size + int(k)) + 1 for k in elements])
    waves = np.column_stack([np.ones(1001), t[1000:], np.sin(rate * t[1000:]),
                             np.cos(rate * t[1000:])])  # fmt: skip
    for k in (8, 11, 14):
        quasi = (high.loads[k, 0] - low.loads[k, 0]) / 0.02
        _, _, sine, cosine = np.linalg.lstsq(waves, loads[1000:, k, 0], rcond=None)[0]
        reduced = 0.5 * rate * chord[k] / np.hypot(5.0, RPM * np.pi / 30.0 * r[k])
        h1, h0 = hankel2(1, reduced), hankel2(0, reduced)
        expected = h1 / (h1 + 1j * h0)
        assert 0.1 < reduced < 1.0
        assert abs((sine + 1j * cosine) / (0.01 * quasi) - expected) < 0.03


def test_a_blade_that_turns_about_its_axis_is_damped(tmp_path, monkeypatch):
    """About the quarter chord, whatever the wake does: pi/8 rho V c^3 per length."""
    chord, wind = thin(monkeypatch, 0.02), "speed = { constant = 10.0 }"
    solver = 't_end = 0.3\noutput_step = 0.001\nintegrator = "rk8"\nrtol = 1e-7'
    file = write_rotor(tmp_path, wind, pitch=83.0, solver=solver)
    text = re.sub(r"drive = \{ speed = [^}]*\}", "drive = { speed = 0.0 }", file.read_text())
    hinge = '[joints.f0]\nkind = "revolute"\naxis = [0.0, 0.0, 1.0]\n'
    text = text.replace('[joints.f0]\nkind = "fixed"\n', hinge)
    text = text.replace("inertia = [[10.0,", "inertia = [[1e-4,")
    text += '[forces.spring]\nkind = "coordinate_force"\njoint = "f0"\nexpression = "0.01 - x"\n'
    text += '[signals.angle]\nkind = "joint"\njoint = "f0"\n'
    result, _ = computed_file(file, text, run="all")
    angle = next(s.values for s in result.signals if s.name == "angle")
    c = np.pi / 8.0 * 1.225 * 10.0 * (stations()["width"] * chord**3).sum()

    def decaying(t, mean, size, rate, w, phase):
        return mean + size * np.exp(-rate * t) * np.cos(w * t + phase)

    fit, _ = curve_fit(decaying, result.t, angle, [0.01, -0.01, c / 2e-4, 100.0, 0.0])
    assert fit[2] == pytest.approx(c / 2e-4, rel=0.02)


def test_a_start_is_steady_and_energy_balances(tmp_path):
    """Nothing changes in a steady wind; work of the air is what the drive takes."""
    solver = 't_end = 1.0\noutput_step = 0.1\nintegrator = "rk5"'
    file = write_rotor(tmp_path, solver=solver)
    result, summary = computed_file(file, run="all")
    thrust = next(s.values for s in result.signals if s.name == "thrust")
    np.testing.assert_allclose(thrust, thrust[0], rtol=1e-6)
    assert not summary["warnings"]


def test_the_hub_takes_the_torque(tmp_path):
    """A free rotor: inertia times acceleration is the aerodynamic torque; power is its product."""
    solver = 't_end = 0.2\noutput_step = 0.01\nintegrator = "rk8"\nrtol = 1e-8'
    file = write_rotor(tmp_path, free=True, solver=solver)
    result, _ = computed_file(file, run="all")
    found = {s.name: s.values for s in result.signals}
    assert found["speed"][0] == pytest.approx(RPM * np.pi / 30.0)
    inertia = 2e5 + 3 * 9000.0
    rate = np.gradient(found["speed"], result.t, edge_order=2)
    np.testing.assert_allclose(inertia * rate[1:-1], found["torque"][1:-1], rtol=1e-3)
    np.testing.assert_allclose(found["power"], found["torque"] * found["speed"], rtol=1e-12)


def test_a_rotor_that_the_wind_turns_has_no_equilibrium(tmp_path, monkeypatch):
    """The search went on with the turning rotor, over five minutes with flexible blades."""
    monkeypatch.setattr(equilibrium, "_PATIENT", 2)
    solver = 't_end = 1.0\noutput_step = 0.1\nstart = "equilibrium"'
    case = load_case(write_rotor(tmp_path, free=True, solver=solver))
    with pytest.raises(InputError, match=r"within \d steps.*in the wind, use `spin="):
        prepare(case.runs["all"], {})


def test_strips_that_do_not_fit_the_axis_are_refused(tmp_path):
    """Another axis, or strips in mm, and the numbers that show it."""
    file = write_rotor(tmp_path)
    text = file.read_text()
    wrong = text.replace("axis = [1.0, 0.0, 0.0]\nblades", "axis = [0, 0, 1]\nblades")
    strips = [line.split(",") for line in (tmp_path / "aero.csv").read_text().splitlines()]
    in_mm = [[a, f"{b}e3", f"{c}e3", *rest] for a, b, c, *rest in strips[1:]]
    for content, rows, words in (
        (wrong, strips, r"rotor.axis = \[0.0, 0.0, 1.0\]: the strips of b0"),
        (text, [strips[0], *in_mm], "widths of the strips of b0 add up to 19000 m.*in m"),
    ):
        file.write_text(content)
        (tmp_path / "aero.csv").write_text("\n".join(map(",".join, rows)))
        case = load_case(file)
        with pytest.raises(InputError, match=words):
            build(case.runs["all"], {})


def test_lift_is_made_of_attached_and_separated_flow():
    """f cl_attached + (1 - f) cl_separated is the polar; f = 1 at small angles, 0 when stalled."""
    from samples.rotor_samples import ANGLES, polar

    c = polar()
    rows = polar_rows(Polar(alpha_deg=ANGLES.tolist(), cl=c[:, 0].tolist(), cd=c[:, 1].tolist(),
                            cm=c[:, 2].tolist()))  # fmt: skip
    alpha = np.degrees(np.linspace(-np.pi, np.pi, len(rows)))
    f, span = rows[:, 3], rows[:, 4]
    assert f.min() >= 0.0
    assert f.max() <= 1.0
    near = np.abs(alpha + 3.0) < 5.0
    assert f[near].min() > 0.95
    assert f[np.abs(alpha - 25.0) < 0.3].max() < 0.3
    # lift with frozen separation continues with the attached slope less the share that is lost
    zero = np.radians(-3.0)
    inside = (alpha > 0.0) & (alpha < 25.0)
    attached = rows[inside, 0] + (1.0 - f[inside]) * span[inside]
    linear = attached / (np.radians(alpha[inside]) - zero)
    np.testing.assert_allclose(linear, linear[0], rtol=1e-3)
    assert linear[0] == pytest.approx(2.0 * np.pi, rel=0.01)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, ""),
        ({"drive = { speed = 4.1": "drive = { speed = 14.1"}, "speed of the shaft in rad/s"),
        ({"constant = 10.0": "constant = 43.2"}, "the wind in m/s, not in km/h?"),
        ({"[rotor.wind]": "[rotor.wind]\nshear_exponent = 0.2"}, "origin of the case on"),
        ({"[rotor]": "[rotor]\nair_density = 1.2e-3"}, "air_density = 0.0012 kg/m3"),
        ({"[rotor]": "[rotor]\nair_density = 1225.0"}, "air_density = 1225 kg/m3"),
        ({"[rotor]": "[rotor]\nair_density = 1025.0"}, ""),
        ({"title": 'allow = ["size-units"]\ntitle', "constant = 10.0": "constant = 120.0"}, ""),
    ],
)
@pytest.mark.provokes("size-units")
def test_a_rotor_in_other_units_is_doubted(tmp_path, change, words):
    file = write_rotor(tmp_path, solver="t_end = 0.02\noutput_step = 0.01")
    text = file.read_text()
    for old, new in change.items():
        assert old in text
        text = text.replace(old, new, 1)
    _, summary = computed_file(file, text, run="all")
    found = [w["message"] for w in summary["warnings"] if w["code"] == "size-units"]
    assert len(found) == bool(words)
    assert all(message.startswith("rotor: ") and words in message for message in found)
