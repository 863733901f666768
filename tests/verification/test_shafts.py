"""Shafts in compliant bearings: modes at every speed, Campbell diagrams, critical speeds passed."""

from dataclasses import replace

import numpy as np
import pytest
from peers.rotor_beam import Rotor
from samples.beam_samples import CHORD, reduced
from samples.case_samples import HEAD, computed_file
from samples.modes_samples import modes_at, rates
from scipy.integrate import solve_ivp

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.checks.stability import SpinMonitor
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.integrators.generic.drive import Steps
from plymotion.solver.mechanism.build import build
from plymotion.solver.package import write_package
from plymotion.solver.run.execution import read_run

LENGTH, DIAMETER, E, RHO = 1.0, 0.02, 2.1e11, 7800.0
AXIS = ("--axis", "1,0,0")
BENDING = [{"kind": f"bending-{plane}", "count": 3} for plane in ("xy", "xz")]
AT_DISC = {"kind": "attachment", "at": "disc", "directions": ["y", "z", "ry", "rz"]}
STIFF = [
    {"kind": "torsion", "count": 2},
    {"kind": "axial", "count": 1},
    {"kind": "attachment", "at": "disc", "directions": ["x", "rx"]},
]


def shaft(d=DIAMETER, rho=RHO, ratio=1.0, more=(), **changes):
    """A round shaft on its two ends with a place for a disc; `ratio` of its two frequencies."""
    A, I2 = np.pi * d**2 / 4, np.pi * d**4 / 64
    shear = 0.9 * E / 2.6 * A
    K = np.diag([E * A, shear, shear, E / 1.3 * I2, E * I2 * ratio**2, E * I2])
    mass = SectionMass(rho * A, np.zeros(3), rho * I2 * np.diag([2.0, 1.0, 1.0])).matrix()
    places = {"root": {"at": "start"}, "disc": {"at": 0.5}, "tip": {"at": "end"}}
    modes = [*BENDING, AT_DISC, *more]
    return reduced(
        CHORD, modes, elements=12, K=K, mass=mass, length=LENGTH, interfaces=places, **changes
    ).package


def stiffness_of(d=DIAMETER):
    """Of the shaft at its middle, 48 E I / L^3 and shear [N/m]."""
    A, I2 = np.pi * d**2 / 4, np.pi * d**4 / 64
    return 1.0 / (LENGTH**3 / (48.0 * E * I2) + LENGTH / (4.0 * 0.9 * E / 2.6 * A))


def bushing(name, place, k, c):
    return (
        f'[ground.{name}]\nposition = [{place}, 0.0, 0.0]\n[forces.{name}]\nkind = "bushing"\n'
        f'between = ["ground.{name}", "shaft.{name}"]\nstiffness = {[float(v) for v in k]}\n'
        f"damping = {[float(v) for v in c]}\n"
    )


def rotor(k=1e6, c=100.0, mass=2.0, inertia=(0.004, 0.0025), off=0.0, torque=0.0, spin=0.0):
    """A shaft with a disc, whose mass is `off` the line, in two isotropic bearings."""
    turning = f"angular_velocity = [{spin}, 0.0, 0.0]\n"
    text = f'[bodies.shaft]\nkind = "package"\npackage = "shaft.vtkhdf"\n{turning}'
    J = np.diag([inertia[0], inertia[1], inertia[1]]).tolist()
    text += (
        f'[bodies.disc]\nkind = "rigid"\nmass = {mass}\ninertia = {J}\n{turning}'
        f"position = [{LENGTH / 2}, {off}, 0.0]\n"
        f"interfaces = {{ c = {{ position = [0.0, {-off}, 0.0] }} }}\n"
        '[joints.disc]\nkind = "fixed"\nbetween = ["shaft.disc", "disc.c"]\n'
    )
    text += bushing("root", 0.0, (k, k, k), (c, c, c)) + bushing(
        "tip", LENGTH, (0, k, k), (0, c, c)
    )
    if torque:
        text += (
            '[forces.drive]\nkind = "torque"\nat = "shaft.root"\ndirection = [1.0, 0.0, 0.0]\n'
            f'law = {{ expression = "{torque}" }}\n'
        )
    text += '[signals.y]\nkind = "position"\nat = "disc.c"\ncomponent = "y"\n'
    text += '[signals.z]\nkind = "position"\nat = "disc.c"\ncomponent = "z"\n'
    return text + '[signals.w]\nkind = "angular_velocity"\nat = "shaft.root"\ncomponent = "x"\n'


def written(folder, package):
    (folder / "sample").mkdir(exist_ok=True)
    write_package(folder / "sample" / "shaft.vtkhdf", package)
    return folder


@pytest.mark.parametrize("more", ["", "geometric_stiffening = true\n"])
@pytest.mark.parametrize("d", [0.006, DIAMETER])
def test_every_speed_is_accepted(d, more, tmp_path, capsys):
    """Twist and stretch are stiff: the stiffness of the free turn is their round-off."""
    written(tmp_path, shaft(d, more=STIFF))
    for speed in (60, 231, 600):
        found = modes_at(tmp_path, rotor(), f"spin={speed}", *AXIS, capsys=capsys, more=more)
        first, second = found["modes"][:2]
        assert first["angular_frequency"] == 0.0
        assert second["angular_frequency"] > 1.0
        assert not found["notes"]


def point_rotor(k, c, mass):
    """A rigid disc on two springs: Jeffcott's rotor, with tilting far above."""
    text = f'[bodies.shaft]\nkind = "rigid"\nmass = {mass}\n'
    text += "inertia = [[0.036, 0, 0], [0, 0.02, 0], [0, 0, 0.02]]\n"
    text += (
        "interfaces = { root = { position = [-0.3, 0, 0] }, tip = { position = [0.3, 0, 0] } }\n"
    )
    half, damped = (k / 2,) * 3, (c / 2,) * 3
    return text + bushing("root", -0.3, half, damped) + bushing("tip", 0.3, half, damped)


@pytest.mark.parametrize("ratio", [0.0, 0.01, 0.5])
def test_jeffcott_rotor_through_its_critical_speed(ratio, tmp_path, capsys):
    """w = sqrt(k / m) (sqrt(1 - ratio^2)) at every speed, the critical one included."""
    text = point_rotor(4e4, 2.0 * ratio * 400.0, 4.0)
    found = modes_at(tmp_path, text, "spin=0:300:20", *AXIS, capsys=capsys)
    damped = 100.0 * np.sqrt(1.0 - ratio**2)
    # Both have the same frequency, so that either may get the name of y.
    whirls = [b for b in found["branches"] if b["main"].startswith(("shaft y, ", "shaft z, "))]
    assert [np.sign(b["fixed_axes_angular_frequency"][-1]) for b in whirls] in ([-1, 1], [1, -1])
    for branch in whirls:
        w = np.abs(np.array(branch["fixed_axes_angular_frequency"], dtype=float))
        assert w == pytest.approx(damped, rel=1e-9)
        assert np.array(branch["damping_ratio"]) == pytest.approx(ratio, abs=1e-9)
        speeds = [x["speed"] for x in found["crossings"] if x["branch"] == branch["branch"]]
        assert any(abs(speed / damped - 1.0) < 1e-6 for speed in speeds)
    assert not found["notes"]


@pytest.mark.parametrize("speed", [0.0, 100.0, 300.0])
def test_bearings_of_two_stiffnesses(speed, tmp_path, capsys):
    """A rigid rotor in axes at rest, four times as stiff along z: roots of its linear equations.

    The line moves by y + x b and z - x a at x, with the tilts a and b about y and z:
    I a'' + I_p W b' = sum x k_z (z - x a), I b'' - I_p W a' = -sum x k_y (y + x b).
    """
    m, across, polar, places, k = 4.0, 0.02, 0.036, (-0.3, 0.2), (1e4, 2e4)
    text = f'[bodies.shaft]\nkind = "rigid"\nmass = {m}\nangular_velocity = [{speed}, 0.0, 0.0]\n'
    text += f"inertia = {np.diag([polar, across, across]).tolist()}\n[bodies.shaft.interfaces]\n"
    for name, x, stiffness in zip(("root", "tip"), places, k, strict=True):
        text = text.replace("interfaces]\n", f"interfaces]\n{name}.position = [{x}, 0.0, 0.0]\n")
        text += bushing(name, x, (1e4, stiffness, 4.0 * stiffness), (0, 0, 0))
    found = modes_at(tmp_path, text, "start", capsys=capsys)
    K, G = np.zeros((4, 4)), np.zeros((4, 4))  # y, z, a, b
    for x, stiffness in zip(places, k, strict=True):
        up, side = np.array([0.0, 1.0, -x, 0.0]), np.array([1.0, 0.0, 0.0, x])
        K += 4.0 * stiffness * np.outer(up, up) + stiffness * np.outer(side, side)
    G[2, 3], G[3, 2] = polar * speed, -polar * speed
    M = np.diag([m, m, across, across])
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(M, K), -np.linalg.solve(M, G)]])
    roots = np.linalg.eigvals(A)
    expected = np.sort([*roots.imag[roots.imag > 0.0], np.sqrt(1e4 * 2.0 / m)])  # and along x
    assert np.sort(rates(found)) == pytest.approx(expected, rel=1e-8)


def by_speed(place, k, c, cross):
    """A bearing of coefficients over the speed: loads by expressions along two directions."""
    speed = f'angular_velocity("{place}", "x")'
    text = ""
    for a, b, sign, direction in (("y", "z", "-", [0, 1, 0]), ("z", "y", "+", [0, 0, 1])):
        force = f'-{k}({speed}) * position("{place}", "{a}") - {c} * velocity("{place}", "{a}")'
        force += f' {sign} {cross} * position("{place}", "{b}")'
        text += f'[forces."{place[6:]}-{a}"]\nkind = "force"\nat = "{place}"\n'
        text += f"direction = {direction}\nlaw = {{ expression = '{force}' }}\n"
    return text


@pytest.mark.parametrize("cross", [0.0, 200.0, 1000.0])
def test_bearings_with_coefficients_over_the_speed(cross, tmp_path, capsys):
    """Whirl of (k(W) - m w^2 + i c w) z -+ i k_c z = 0: cross stiffness takes the damping away."""
    mass, c = 4.0, 5.0
    speeds, k = np.array([0.0, 100.0, 200.0, 300.0]), np.array([4e4, 3e4, 2.4e4, 2e4])
    text = "\n".join(
        line for line in point_rotor(0.0, 0.0, mass).splitlines() if not line.startswith("[forces")
    ).split("[ground")[0]
    text += '[ground.o]\nposition = [-0.3, 0.0, 0.0]\n[forces.axial]\nkind = "bushing"\n'
    text += 'between = ["ground.o", "shaft.root"]\nstiffness = [1e4, 0.0, 0.0]\n'
    text += f'[tables.k]\nx = {speeds.tolist()}\ny = {(k / 2).tolist()}\ninterpolation = "linear"\n'
    for end in ("root", "tip"):
        text += by_speed(f"shaft.{end}", "k", c, cross / 2)
    found = modes_at(tmp_path, text, "spin=0:300:50", *AXIS, capsys=capsys)
    for speed in (50.0, 250.0):
        row = found["speeds"].index(speed)
        at = np.interp(speed, speeds, k)
        for sign, word in ((1.0, "forward"), (-1.0, "backward")):
            values = np.roots([mass, 2 * c, at - 1j * cross])  # z = exp(lambda t), both directions
            wanted = values[np.argmax(sign * values.imag)]
            (branch,) = (
                b
                for b in found["branches"]
                if b["main"] in (f"shaft y, {word}", f"shaft z, {word}")
            )
            assert branch["fixed_axes_angular_frequency"][row] == pytest.approx(
                wanted.imag, rel=1e-7
            )
            ratio = -wanted.real / abs(wanted)
            assert branch["damping_ratio"][row] == pytest.approx(ratio, abs=1e-8)


@pytest.mark.parametrize("c", [0.0, 100.0])
def test_campbell_diagram_of_a_balanced_shaft_does_not_end(c, tmp_path, capsys):
    more = "geometric_stiffening = true\n"
    written(tmp_path, shaft(more=STIFF))
    still = modes_at(tmp_path, rotor(c=c), "equilibrium", capsys=capsys, more=more)
    critical = next(w for m in still["modes"] if (w := m["angular_frequency"]) > 1.0)
    span = f"spin={0.5 * critical}:{1.5 * critical}:{0.25 * critical}"
    found = modes_at(tmp_path, rotor(c=c), span, *AXIS, capsys=capsys, more=more)
    for branch in found["branches"][:2]:
        assert None not in branch["fixed_axes_angular_frequency"]
        assert np.abs(branch["fixed_axes_angular_frequency"]) == pytest.approx(critical, rel=1e-3)
    assert not found["notes"]


@pytest.mark.parametrize("c_i", [20.0, 80.0])
def test_internal_damping_makes_a_rotor_unstable_above_a_speed(c_i, tmp_path, capsys):
    """W < w (1 + c_e / c_i), of a light shaft with damping in it and of the disc outside it."""
    k, mass, c_e = stiffness_of(), 4.0, 20.0
    package = shaft(rho=1.0)
    written(tmp_path, replace(package, damping=c_i / k * package.stiffness))
    text = rotor(k=1e10, c=0.0, mass=mass) + bushing("disc", LENGTH / 2, (0, 0, 0), (0, c_e, c_e))
    limit = np.sqrt(k / mass) * (1.0 + c_e / c_i)
    for share, unstable in ((0.99, False), (1.01, True)):
        found = modes_at(tmp_path, text, f"spin={share * limit}", *AXIS, capsys=capsys)
        growing = [m for m in found["modes"] if m["damping_ratio"] < -1e-9]
        assert bool(growing) == unstable
        assert all(m["fixed_axes_angular_frequency"] > 0.0 for m in growing)  # forward whirl


def computed(folder, package, text, t_end, more=""):
    """Times, signals and summary of a run."""
    write_package(folder / "shaft.vtkhdf", package)
    file = folder / "case.toml"
    keys = f"t_end = {t_end}\noutput_step = {t_end / 1000}\nrtol = 1e-7\n{more}"
    result, summary = computed_file(file, f"{HEAD}{text}[solver]\n{keys}[runs.base]\n")
    return result.t, {s.name: s.values for s in result.signals}, summary


def codes(summary):
    return {warning["code"] for warning in summary["warnings"]}


def jeffcott_run_up(t, k, c, mass, J, off, torque):
    """Deflection (n,) complex and spin (n,) of a point mass at `off` of a massless shaft.

    m (z + e exp(i theta))" + c z' + k z = 0,  J theta" = torque - m e Im((z + e exp(i theta))"
    exp(-i theta)).
    """

    def rates(_, y):
        z, z_d, angle, w = y[0] + 1j * y[1], y[2] + 1j * y[3], y[4], y[5]
        turn = np.exp(1j * angle)
        force = -c * z_d - k * z  # on the mass
        w_d = (torque - off * (force * turn.conj()).imag) / J
        z_dd = force / mass - off * (1j * w_d - w**2) * turn
        return [z_d.real, z_d.imag, z_dd.real, z_dd.imag, w, w_d]

    y = solve_ivp(rates, (0.0, t[-1]), np.zeros(6), "DOP853", t, rtol=1e-10, atol=1e-12).y
    return y[0] + 1j * y[1], y[5]


@pytest.mark.parametrize("stiffened", [False, True])
@pytest.mark.parametrize("bearing", [1e5, 1e9])
def test_run_up_through_the_critical_speed(bearing, stiffened, tmp_path):
    """Jeffcott's rotor, integrated by itself; the shaft is above the speed of its own frame."""
    mass, off, c, torque = 2.0, 1e-4, 30.0, 1.0
    k = 1.0 / (1.0 / stiffness_of() + 1.0 / (2.0 * bearing))
    text = rotor(k=bearing, c=0.0, mass=mass, off=off, torque=torque)
    text += bushing("disc", LENGTH / 2, (0, 0, 0), (0, c, c))
    more = "geometric_stiffening = true\n" if stiffened else ""
    t, found, summary = computed(tmp_path, shaft(rho=10.0), text, 1.2, more)
    twist = 10.0 * np.pi * DIAMETER**4 / 32 * LENGTH
    z, w = jeffcott_run_up(t, k, c, mass, 0.004 + twist, off, torque)
    assert w[-1] > max(1.5 * np.sqrt(k / mass), np.sqrt(stiffness_of() / mass))
    assert found["w"] == pytest.approx(w, abs=2e-3 * w[-1])
    size = np.abs(z).max()
    assert found["y"] + 1j * found["z"] == pytest.approx(z, abs=0.02 * size)
    assert summary["status"] == "finished"
    assert not codes(summary) & {
        "buckling-by-motion",
        "buckling-load",
        "spin-above-clamped-frequency",
    }


def test_a_run_that_starts_above_the_critical_speed(tmp_path):
    """e W^2 / (w^2 - W^2): above the critical speed the mass centre moves to the axis."""
    bearing, off = 1e5, 1e-4
    k = 1.0 / (1.0 / stiffness_of() + 1.0 / (2.0 * bearing))
    W = 2.0 * np.sqrt(stiffness_of() / 2.0)
    spin = f'start = "equilibrium"\nspin = {{ axis = [1.0, 0.0, 0.0], speed = {W} }}\n'
    text = rotor(k=bearing, c=0.0, off=off)
    _, found, summary = computed(tmp_path, shaft(rho=10.0), text, 0.1, spin)
    expected = off * W**2 / abs(k / 2.0 - W**2)
    assert np.hypot(found["y"], found["z"]) == pytest.approx(expected, rel=2e-3)
    assert summary["status"] == "finished"
    assert not codes(summary)


@pytest.mark.parametrize("share", [0.9, 1.0, 1.1])
def test_orbit_of_an_unbalanced_shaft_at_a_given_speed(share, tmp_path, capsys):
    """e W^2 / |w^2 - W^2 + i c W / m|; what the damper takes about the axis is the drive's."""
    bearing, off, c, mass = 1e6, 1e-4, 30.0, 2.0
    k = 1.0 / (1.0 / stiffness_of() + 1.0 / (2.0 * bearing))
    W = share * np.sqrt(k / mass)
    text = rotor(k=bearing, c=0.0, mass=mass, off=off)
    text += bushing("disc", LENGTH / 2, (0, 0, 0), (0, c, c))
    spin = f'start = "equilibrium"\nspin = {{ axis = [1.0, 0.0, 0.0], speed = {W} }}\n'
    _, found, _ = computed(tmp_path, shaft(rho=10.0), text, 1e-3, spin)
    expected = off * W**2 / abs(k / mass - W**2 + 1j * c * W / mass)
    assert np.hypot(found["y"][0], found["z"][0]) == pytest.approx(expected, rel=5e-3)
    written(tmp_path, shaft(rho=10.0))
    modes = modes_at(tmp_path, text, f"spin={W}", *AXIS, capsys=capsys)
    assert not any("equilibrium" in note for note in modes["notes"])


def thick(place=0.5, twist=0.0, count=6, elements=48):
    """A tube of 10 % of its length with couplings in 3e7 N/m, and its finite elements."""
    r, t, rho = 0.05, 0.006, 1550.0
    A, I2, E, G = 2 * np.pi * r * t, np.pi * r**3 * t, 9e10, 1.2e10
    K = np.diag([E * A, G * A / 2, G * A / 2, 2 * G * I2, E * I2, E * I2])
    K[0, 3] = K[3, 0] = twist * np.sqrt(K[0, 0] * K[3, 3])
    K[1, 4] = K[4, 1] = K[2, 5] = K[5, 2] = twist * np.sqrt(K[1, 1] * K[4, 4])
    section = SectionMass(rho * A, np.zeros(3), rho * I2 * np.diag([2.0, 1.0, 1.0])).matrix()
    places = {"root": {"at": "start"}, "disc": {"at": place}, "tip": {"at": "end"}}
    kinds = ("bending-xy", "bending-xz")
    modes = [*({"kind": kind, "count": count} for kind in kinds), AT_DISC]
    package = reduced(
        CHORD, modes, elements=elements, K=K, mass=section, length=LENGTH, interfaces=places
    ).package
    k, c, mass, inertia = 3e7, 500.0, 4.0, (0.03, 0.018)
    peer = Rotor(
        K, rho * A, (2 * rho * I2, rho * I2), LENGTH, place, (mass, *inertia), [(k, c)] * 2
    )
    text = rotor(k, c, mass, inertia, OFF).replace("position = [0.5,", f"position = [{place},")
    return package, peer, text


OFF, STIFFENED = 1e-6, "geometric_stiffening = true\n"


@pytest.mark.parametrize(("place", "twist"), [(0.5, 0.0), (0.35, 0.2)])
def test_thick_composite_shaft_against_finite_elements(place, twist, tmp_path, capsys):
    """Sections that tilt, coupled in bending and shear, extension and twist, with a disc.

    Rotations of first order alone leave whirls 5e-3 off at three times the critical speed.
    """
    package, peer, text = thick(place, twist)
    first = peer.whirls(0.0)[0]
    more = "geometric_stiffening = true\n"
    written(tmp_path, package)
    found = modes_at(tmp_path, text, f"spin={2.5 * first}", *AXIS, capsys=capsys, more=more)
    rates = np.abs([m["fixed_axes_angular_frequency"] or 0.0 for m in found["modes"]])
    for w in peer.whirls(2.5 * first)[:4]:
        assert np.abs(rates / w - 1.0).min() < 5e-4, w
    for share in (0.7, 1.3, 2.5):
        spin = f"spin = {{ axis = [1.0, 0.0, 0.0], speed = {share * first} }}\n"
        keys = f'start = "equilibrium"\n{spin}{more}'
        _, signals, _ = computed(tmp_path, package, text, 1e-5, keys)
        size = np.hypot(signals["y"][0], signals["z"][0])
        assert size == pytest.approx(peer.orbit(share * first, OFF), rel=2e-4)


@pytest.mark.provokes("sections-tilt")
def test_a_linear_shaft_is_told_what_its_sections_lack(tmp_path, capsys):
    """By twice the error of its whirls; a stiffened and a slow one are not told."""
    package, peer, text = thick(count=3, elements=12)
    written(tmp_path, package)
    fast = 2900.0  # [rad/s] 2.5 times the first critical speed
    for speed, more, told in ((fast, "", True), (fast, STIFFENED, False), (500.0, "", False)):
        keys = f"spin = {{ axis = [1.0, 0.0, 0.0], speed = {speed} }}\n{more}"
        _, _, summary = computed(tmp_path, package, text, 1e-5, f'start = "equilibrium"\n{keys}')
        found = [w["value"] for w in summary["warnings"] if w["code"] == "sections-tilt"]
        assert len(found) == told
        if told:
            modes = modes_at(tmp_path, text, f"spin={speed}", *AXIS, capsys=capsys)
            assert "sections of a linear body" in modes["notes"][0]
            rates = np.abs([m["fixed_axes_angular_frequency"] or 0.0 for m in modes["modes"]])
            errors = [np.abs(rates / w - 1.0).min() for w in peer.whirls(speed)[:2]]
            assert 0.3 * found[0] < max(errors) < 0.5 * found[0]


def monitor_of(folder, package):
    file = folder / "case.toml"
    write_package(folder / "shaft.vtkhdf", package)
    file.write_text(f"{HEAD}{rotor()}[solver]\nt_end = 1.0\noutput_step = 0.1\n[runs.base]\n")
    write_case(load_case(file), folder / "build")
    spec = read_run(folder / "build/runs/base.json")
    built = build(spec.mechanism, spec.packages)
    return SpinMonitor(built.model, built.body_names), built.model


@pytest.mark.parametrize(("ratio", "held"), [(1.0, True), (1.02, True), (1.3, False)])
def test_a_shaft_of_two_stiffnesses_grows_between_its_critical_speeds(ratio, held, tmp_path):
    """By (w_2 - w_1) / 2; below and above both, and about other axes, nothing changes."""
    monitor, model = monitor_of(tmp_path, shaft(ratio=ratio))
    y = np.zeros(model.n_pos + model.n_vel)
    axis = np.array([1.0, 0.0, 0.0])
    first = monitor.critical_spin(0, axis)  # of the body with its disc in its frame

    def margin(w):
        y[model.n_pos + 3 : model.n_pos + 6] = w
        return monitor.margin(0, y)

    assert margin(0.99 * first * axis) > 0.0
    assert (margin(0.5 * (1.0 + ratio) * first * axis + 1e-3 * axis) > 0.0) == held
    assert margin(1.2 * ratio * first * axis) > 0.0
    across = np.array([0.0, 0.0, 1.0])  # a blade has one soft direction only
    assert margin(1.01 * monitor.critical_spin(0, across) * across) < 0.0


def test_a_shaft_is_judged_at_each_speed_about_one_axis(tmp_path):
    """What holds it above both critical speeds does not hold it between them."""
    monitor, model = monitor_of(tmp_path, shaft(ratio=1.3))
    first = monitor.critical_spin(0, np.array([1.0, 0.0, 0.0]))
    y = np.zeros((3, model.n_pos + model.n_vel))
    y[:, model.n_pos + 3] = first * np.array([1.6, 1.6, 1.15])
    steps = Steps(np.array([0.0, 0.1, 0.2]), y, lambda _: pytest.fail("no state is asked for"))
    assert monitor.margin(0, y[1]) > 0.0 > monitor.margin(0, y[2])
    assert monitor._first_invalid(0, steps) == 1
