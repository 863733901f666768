"""Beams in segments at large rotations, against published values and closed forms."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.flexible_samples import momenta
from samples.segment_samples import cantilever, on_hub, run_of
from samples.stiffening_samples import rectangle

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.dynamics.elements.marker import marker_motion
from plymotion.solver.package import read_package
from plymotion.solver.results.codes import INDEFINITE, ROTATION
from plymotion.solver.run.execution import execute
from plymotion.solver.run.preparation import prepare

REFERENCE = "large_rotations"


def slowly_loaded(
    table: dict[str, Any], kind: str, direction: list[float], value: float, time: float
):
    """The case with a load at the tip that rises slowly, and some damping."""
    law = {"smooth_step": {"value": value, "duration": time}}
    load = {"kind": kind, "at": "beam.tip", "direction": direction, "law": law}
    table["bodies"]["beam"]["damping_ratio"] = 0.3
    table["solver"] |= {"t_end": 1.2 * time, "output_step": 0.2 * time, "rtol": 1e-5}
    return table | {"forces": {"load": load}}


def at_the_end(table: dict[str, Any], matrices) -> tuple[np.ndarray, dict[str, Any]]:
    result, summary = execute(run_of(table, matrices), progress=False)
    assert summary["completed"]
    return np.array([signal.values[-1] for signal in result.signals]), summary


def in_equilibrium(table: dict[str, Any], matrices, at: str, load: list[float]) -> np.ndarray:
    """Position of a place in static equilibrium under a dead force at the tip."""
    force = {"kind": "force", "at": "beam.tip", "direction": load}
    table["forces"] = {"load": force | {"law": {"polynomial": [float(np.linalg.norm(load))]}}}
    return started_at(table, matrices, at)


def started_at(table: dict[str, Any], matrices, at: str) -> np.ndarray:
    """Position of a place in the state of equilibrium in which the case starts."""
    table["signals"] = {"x": {"kind": "position", "at": at, "component": "x"}}
    table["solver"]["start"] = "equilibrium"
    spec = run_of(table, matrices)
    ready = prepare(spec.mechanism, spec.packages)
    return marker_motion(ready.model, ready.built.signal_marker["x"], ready.y0).x


@pytest.mark.parametrize("segments", [8, 12])
def test_cantilever_rolls_up_to_a_circle(segments: int) -> None:
    """The end moment 2 pi EI / L: the tip comes back to the root."""
    K = np.diag([1e4, 1e4, 1e4, 50.0, 100.0, 1.0])
    mass = SectionMass(1.0, np.zeros(3), np.diag([2e-4, 1e-4, 1e-4])).matrix()
    table = cantilever(segments, 1.0)
    table["signals"]["turn"] = {"kind": "rotation", "at": "beam.tip", "component": "z"}
    table = slowly_loaded(table, "torque", [0.0, 0.0, 1.0], 2.0 * np.pi, 100.0)
    found, _ = at_the_end(table, (K, mass))
    np.testing.assert_allclose(found, [-1.0, 0.0, 0.0, 2.0 * np.pi], atol=5e-6)


@pytest.mark.parametrize("turns", [0.5, 1.0])
def test_equilibrium_of_a_beam_bent_to_a_circle(turns: float) -> None:
    """Half and whole circle under an end moment, found from the straight beam at once."""
    K = np.diag([1e4, 1e4, 1e4, 50.0, 100.0, 1.0])
    mass = SectionMass(1.0, np.zeros(3), np.diag([2e-4, 1e-4, 1e-4])).matrix()
    angle, off = 2.0 * np.pi * turns, {}
    expected = [np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle, 0.0]
    load = {"kind": "torque", "at": "beam.tip", "direction": [0.0, 0.0, 1.0]}
    for segments in (4, 8):
        table = cantilever(segments, 1.0)
        table["forces"] = {"load": load | {"law": {"polynomial": [angle]}}}
        tip = started_at(table, (K, mass), "beam.tip")
        off[segments] = np.linalg.norm(np.subtract(tip, expected))
    assert off[8] < 1e-5
    # the error of a segment is of fourth order in its angle; a whole circle closes with any number
    assert off[8] < off[4] / 12.0 or off[4] < 1e-9


@pytest.mark.parametrize("number", range(7))
def test_princeton_beam(reference: dict[str, Any], number: int) -> None:
    data = reference["princeton"]
    h, w, E = data["height"], data["width"], data["E"]
    G, A, I2, I3 = E / 2 / (1 + data["nu"]), h * w, h * w**3 / 12, w * h**3 / 12
    K = np.diag([E * A, G * A, G * A, data["torsion"] * G * (I2 + I3), E * I2, E * I3])
    _, mass = rectangle(E, data["nu"], 2700.0, h, w)
    beta = np.radians(data["beta_deg"][number])
    for known in data["loads"]:
        load = known["force"] * np.array([0.0, -np.cos(beta), np.sin(beta)])
        beam = cantilever(8, data["length"])
        _, y, z = in_equilibrium(beam, (K, mass), "beam.tip", load.tolist())
        expected = [known["down"][number], known["across"][number]]
        gap = np.linalg.norm(np.subtract([-y, z], expected))
        assert gap < data["tolerance"] * np.linalg.norm(expected)


def coupled(data: dict[str, Any], beam: int) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and mass of a beam of Minguet and Dugundji."""
    K = np.diag(data["diagonals"][beam - 1])
    for i, j, value in data["couplings"][beam - 1]:
        K[int(i) - 1, int(j) - 1] = K[int(j) - 1, int(i) - 1] = value
    return K, SectionMass(0.04, np.zeros(3), 1e-6 * np.diag([2, 1, 1])).matrix()


def beneath(data: dict[str, Any], beam: int, turned: float, grams: float) -> np.ndarray:
    """Place 0.5 m from the root of a beam that is turned about its axis, under a weight."""
    there = {"at": 0.5 / data["length"]}
    places = {"root": {"at": "start"}, "there": there, "tip": {"at": "end"}}
    body = {"elements": 44, "interfaces": places, "rotation_deg": [turned, 0.0, 0.0]}
    table, load = cantilever(8, data["length"], body=body), [0.0, 0.0, -9.80665e-3 * grams]
    return in_equilibrium(table, coupled(data, beam), "beam.there", load)


@pytest.mark.parametrize("number", range(6))
def test_loads_on_coupled_beams(reference: dict[str, Any], number: int) -> None:
    """Joints that are closed after each step stretch these slender beams: no equilibrium then."""
    data = reference["minguet"]
    curve, length = data["curves"][number], data["length"]
    found = [beneath(data, curve["beam"], curve["turned_deg"], grams) for grams in curve["load"]]
    _, sideways, up = np.transpose(found)
    np.testing.assert_allclose(-up, curve["down"], atol=data["tolerance"] * length)
    np.testing.assert_allclose(sideways, curve["sideways"], atol=data["tolerance"] * length)
    gap = np.linalg.norm(-up - curve["measured"]) / np.linalg.norm(curve["measured"])
    assert gap < data["measured_tolerance"]


def test_beam_on_edge_buckles_aside(reference: dict[str, Any]) -> None:
    """Upright it is in equilibrium, which is not stable."""
    data, known = reference["minguet"], reference["buckled"]
    x, y, z = beneath(data, 2, 90.0, known["load"])
    gap = np.linalg.norm(np.subtract([x, abs(y), z], known["there"]))
    assert gap < known["tolerance"] * data["length"]


@pytest.mark.parametrize("number", range(2))
def test_upright_beam_swings_out(reference: dict[str, Any], number: int) -> None:
    data, known = reference["minguet"], reference["swung-out"]
    spin, body = known["spins"][number], {"elements": 24, "rotation_deg": [0.0, -90.0, 0.0]}
    table = cantilever(4, data["length"], body=body, gravity=[0.0, 0.0, -9.81])
    table = on_hub(table, known["rim"], spin)
    table["masses"] = {"tip": {"at": "beam.tip", "mass": known["masses"][number]}}
    table["solver"]["spin"] = {"axis": [0.0, 0.0, 1.0], "speed": spin}
    tip = started_at(table, coupled(data, number + 1), "beam.tip")
    gap = np.linalg.norm(tip - known["tips"][number])
    assert gap < known["tolerance"] * data["length"]


def test_bend_of_45_degrees(reference: dict[str, Any]) -> None:
    """Bending in two planes with torsion of a beam that is curved at rest."""
    data = reference["bend"]
    E = data["E"]
    K = np.diag([E, 5 / 12 * E, 5 / 12 * E, E / 12, E / 12, E / 12])
    mass = SectionMass(1.0, np.zeros(3), np.diag([1 / 6, 1 / 12, 1 / 12])).matrix()
    table = cantilever(8, data["radius"] * np.pi / 4, body={"line": {"arc_deg": 45.0}})
    table = slowly_loaded(table, "force", [0.0, 0.0, 1.0], data["force"], 200.0)
    found, _ = at_the_end(table, (K, mass))
    # the bend turns to +y, that of the publications to -y in their axes
    for source in ("bathe", "simo"):
        gap = np.linalg.norm(found - data[source])
        assert gap < data["tolerance"] * np.linalg.norm(data[source]), source


def flying(data: dict[str, Any], segments: int) -> dict[str, Any]:
    """The beam at an angle of atan(4/3), loaded at its lower end."""
    body = {
        "kind": "beam",
        "length": data["length"],
        "section": "s",
        "material": "m",
        "elements": 4 * segments,
        "segments": segments,
        "position": [6.0, 0.0, 0.0],
        "rotation_deg": [0.0, 0.0, 180.0 - np.degrees(np.arctan(4.0 / 3.0))],
        "interfaces": {"low": {"at": "start"}, "mid": {"at": 0.5}, "high": {"at": "end"}},
        "reference": {"kind": "clamped", "at": "mid"},
    }
    t = data["until"]
    law = {"table": {"times": [0.0, t, 20.0], "values": [1.0, 1.0, 1.0], "interpolation": "linear"}}
    loads = {}
    for kind, direction, value in (
        ("force", [1.0, 0.0, 0.0], data["force"]),
        ("torque", [0.0, 0.0, -1.0], data["moment"]),
    ):
        scaled = {"table": {**law["table"], "values": [value] * 3}}
        loads[kind] = {"kind": kind, "at": "beam.low", "direction": direction, "law": scaled}
    return {
        "bodies": {"beam": body},
        "forces": loads,
        "signals": {
            f"{end}_{axis}": {"kind": "position", "at": f"beam.{end}", "component": axis}
            for end in ("low", "high")
            for axis in "xyz"
        },
        "solver": {"t_end": t, "output_step": 0.1, "rtol": 1e-6, "geometric_stiffening": True},
    }


def test_flying_beam_has_the_momentum_of_its_loads(reference: dict[str, Any]) -> None:
    """20 N s after 2.5 s, and an angular momentum of the moment and of the force's arm."""
    data = reference["flying"]
    EA, EI = data["EA"], data["EI"]
    K = np.diag([EA, EA, EA, 100.0 * EI, 100.0 * EI, EI])
    mass = SectionMass(data["mass"], np.zeros(3), data["rotary"] * np.diag([2, 1, 1])).matrix()
    tips = []
    for segments in (6, 12):
        spec = run_of(flying(data, segments), (K, mass))
        result, summary = execute(spec, progress=False)
        assert summary["completed"]
        assert summary["checks"]["energy_drift_relative"] < 1e-5
        model = prepare(spec.mechanism, spec.packages).model
        states = np.hstack([result.q, result.v, np.zeros((len(result.t), 1))])
        linear, angular = zip(*(momenta(model, y) for y in states), strict=True)
        expected = [data["force"] * data["until"], 0.0, 0.0]
        np.testing.assert_allclose(linear[-1], expected, atol=2e-5 * expected[0])
        tips.append([signal.values for signal in result.signals])
        low_y = tips[-1][1]
        rate = -data["moment"] - data["force"] * low_y  # about the origin
        impulse = np.sum(0.5 * np.diff(result.t) * (rate[1:] + rate[:-1]))
        gained = angular[-1][2] - angular[0][2]
        assert gained == pytest.approx(impulse, rel=2e-3)  # the rule of the trapezoids
    # the shape has converged though the beam is bent by more than a right angle
    assert np.abs(np.array(tips[0]) - tips[1])[:, -1].max() < 5e-3 * data["length"]


def test_right_angle_frame(reference: dict[str, Any]) -> None:
    """Bending and torsion by turns, larger than a radian; its mass is mostly rotary inertia."""
    data = reference["elbow"]
    K = np.diag([data["EA"]] * 3 + [data["EI"]] * 3)
    mass = SectionMass(1.0, np.zeros(3), data["rotary"] * np.diag([2, 1, 1])).matrix()
    table = cantilever(4, data["length"])
    second = {"position": [data["length"], 0.0, 0.0], "rotation_deg": [0.0, 0.0, 90.0]}
    table["bodies"]["leg"] = table["bodies"]["beam"] | second
    table["joints"]["elbow"] = {"kind": "fixed", "between": ["beam.tip", "leg.root"]}
    pulse = {"times": [0.0, 1.0, 2.0, 30.0], "values": [0.0, data["force"], 0.0, 0.0]}
    law = {"table": pulse | {"interpolation": "linear"}}
    force = {"kind": "force", "at": "beam.tip", "direction": [0.0, 0.0, 1.0], "law": law}
    table["forces"] = {"push": force}
    table["signals"] = {"tip": {"kind": "position", "at": "leg.tip", "component": "z"}}
    table["solver"] |= {"t_end": 27.0, "output_step": 0.05, "rtol": 1e-4}
    result, summary = execute(run_of(table, (K, mass)), progress=False)
    assert {w["code"] for w in summary["warnings"]} == {ROTATION.name}  # in four segments
    tip = result.signals[0].values
    for t, peak in zip(data["times"], data["peaks"], strict=True):
        near = np.flatnonzero(np.abs(result.t - t) < 3.0)
        top = near[np.argmax(np.sign(peak) * tip[near])]
        assert abs(tip[top] - peak) < data["tolerance"]
        assert abs(result.t[top] - t) < data["time_tolerance"]


@pytest.mark.parametrize("segments", [1, 4])
def test_spin_up(segments: int, repository: Path, published: Callable[[str], Any]) -> None:
    """The manoeuvre of cases/spin-up: least deflection and steady elongation.

    The motion is plane. In space the flat section would give way sideways, which the monitor sees.
    """
    expected = published("spin_up")
    package = read_package(repository / "tests/packages/spin-up/beam.stiffened.vtkhdf")
    section = package.sections[0]
    modes = [{"kind": "bending-xy", "count": 3}, {"kind": "static-axial"}]
    body = {"elements": 16} | ({"modes": modes} if segments == 1 else {})
    table = cantilever(segments, 10.0, body=body)
    drive = {"ramp": {"speed": 6.0, "duration": 15.0, "shape": "sine"}}
    table["joints"] = {
        "hub": {
            "kind": "revolute",
            "between": ["ground.wall", "beam.root"],
            "axis": [0.0, 0.0, 1.0],
            "drive": drive,
        }
    }
    table["solver"] |= {"t_end": 20.0, "output_step": 0.01, "rtol": 1e-6, "on_invalid": "warn"}
    result, summary = execute(run_of(table, (section.K, section.M)), progress=False)
    assert summary["completed"]
    along, across, _ = (signal.values for signal in result.signals)
    found, lowest = expected["stiffened"], int(np.argmin(across))
    assert abs(across[lowest] - found["tip_min"]) < found["tip_min_tolerance"]
    assert abs(result.t[lowest] - found["tip_min_time"]) < found["tip_min_time_tolerance"]
    steady = along[result.t > 15.0].mean()
    assert abs(steady - found["extension"]) < found["extension_tolerance"]


def test_finding_proposes_the_number_of_segments() -> None:
    """Bent by 0.4 rad in one body, and in two; with the proposed numbers there is no finding."""
    K = np.diag([1e4, 1e4, 1e4, 50.0, 100.0, 1.0])
    mass = SectionMass(1.0, np.zeros(3), np.diag([2e-4, 1e-4, 1e-4])).matrix()
    modes = [{"kind": "bending-xy", "count": 2}, {"kind": "attachment", "at": "tip"}]

    def findings(segments: int, moment: float) -> list[str]:
        body = {"elements": 40} | ({"modes": modes} if segments == 1 else {})
        table = cantilever(segments, 1.0, body=body)
        table = slowly_loaded(table, "torque", [0.0, 0.0, 1.0], moment, 20.0)
        _, summary = at_the_end(table, (K, mass))
        found = [w for w in summary["warnings"] if w["code"] == ROTATION.name]
        assert {w["body"] for w in found} <= {"beam"}
        return [w["message"] for w in found]

    for segments, moment in ((1, 0.4), (2, 0.8)):
        (message,) = findings(segments, moment)
        assert f"({segments} now)" in message or segments == 1
        proposed = int(message.partition("segments = ")[2].split()[0])
        assert 4 <= proposed <= 6
        assert findings(proposed, moment) == []


def test_bent_segments_keep_the_inertia_of_their_torsion() -> None:
    """The tip of a slender beam bent by 0.35 rad turns freely: 2 as 6 segments.

    In chord frames of 2 segments the mass of bending with twist became negative here: sums of
    second order lack the product of a deflection and the second-order displacement.
    """
    K = np.diag([1e5, 1e4, 1e4, 20.0, 1.0, 30.0])
    mass = SectionMass(1.0, np.zeros(3), np.diag([1.5e-5, 1e-5, 5e-6])).matrix()
    found = []
    for segments in (2, 6):
        body = {"elements": 12, "damping_ratio": 0.02}
        table = cantilever(segments, 1.0, body=body, gravity=[0.0, 0.0, -2.3])
        table["signals"]["twist"] = {"kind": "rotation", "at": "beam.tip", "component": "x"}
        law = {"smooth_step": {"value": 0.3, "duration": 0.1}}
        load = {"kind": "torque", "at": "beam.tip", "direction": [1.0, 0.0, 0.0], "law": law}
        table["forces"] = {"load": load}
        table["solver"] |= {"t_end": 0.3, "output_step": 0.1, "start": "equilibrium"}
        result, summary = execute(run_of(table, (K, mass)), progress=False)
        assert summary["completed"], summary["message"]
        assert INDEFINITE.name not in {w["code"] for w in summary["warnings"]}
        found.append([signal.values for signal in result.signals])
    assert np.ptp(found[1][3]) > 0.01
    np.testing.assert_allclose(found[0], found[1], atol=2e-3)


def test_finding_calls_a_linear_result_beyond_a_full_turn_invalid() -> None:
    """A linear body bent by 40 rad: no number of segments follows from this."""
    K = np.diag([1e4, 1e4, 1e4, 50.0, 100.0, 1.0])
    mass = SectionMass(1.0, np.zeros(3), np.diag([2e-4, 1e-4, 1e-4])).matrix()
    modes = [{"kind": "bending-xy", "count": 2}, {"kind": "attachment", "at": "tip"}]
    table = cantilever(1, 1.0, body={"elements": 40, "modes": modes})
    table = slowly_loaded(table, "torque", [0.0, 0.0, 1.0], 40.0, 20.0)
    table["solver"]["geometric_stiffening"] = False
    _, summary = at_the_end(table, (K, mass))
    (found,) = (w for w in summary["warnings"] if w["code"] == ROTATION.name)
    assert found["value"] > 2.0 * np.pi
    assert "this result is invalid" in found["message"]
    assert "divide the beam by segments, " in found["message"]


def test_the_free_end_of_a_twisted_beam_needs_no_other_modes() -> None:
    """Its last segment misses a quarter of the twist by its own inertia, 1/16 of the beam's."""
    K = np.diag([1e6, 1e5, 1e5, 50.0, 100.0, 1e3])
    mass = SectionMass(1.0, np.zeros(3), np.diag([2e-4, 1e-4, 1e-4])).matrix()
    table = cantilever(4, 1.0)
    turn = {"drive": {"polynomial": [0.0, 0.0, 0.0, 50.0]}, "axis": [1.0, 0.0, 0.0]}
    table["joints"]["clamp"] |= turn | {"kind": "revolute"}
    signal = {"kind": "rotation", "at": "beam.tip", "component": "x"}
    table["signals"] = {"twist": signal}
    table["solver"]["start"] = "quasi-static"
    (twist,), summary = at_the_end(table, (K, mass))
    assert twist == pytest.approx(-2e-4 * 300.0 / (2.0 * 50.0), rel=0.01)
    assert summary["warnings"] == []


def test_the_rates_of_a_start_are_those_of_the_whole_beam() -> None:
    """Under an angular acceleration of 0.6 t: inertia of 32 segments turns with the first one."""
    K = np.diag([1e6, 1e5, 1e5, 50.0, 100.0, 1.0])
    mass = SectionMass(1.0, np.zeros(3), np.diag([2e-4, 1e-4, 1e-4])).matrix()
    table = cantilever(32, 1.0)
    turn = {"drive": {"polynomial": [0.0, 0.0, 0.0, 0.1]}, "axis": [0.0, 0.0, 1.0]}
    table["joints"]["clamp"] |= turn | {"kind": "revolute"}
    table["solver"]["start"] = "quasi-static"
    table["signals"] = {"y": {"kind": "position", "at": "beam.tip", "component": "y"}}
    spec = run_of(table, (K, mass))
    ready = prepare(spec.mechanism, spec.packages)
    velocity = marker_motion(ready.model, ready.built.signal_marker["y"], ready.y0).v[1]
    assert velocity == pytest.approx(-0.6 * 11.0 / 120.0, rel=2e-3)
