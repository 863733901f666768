"""Requests for signals that are zero: across a plane, of symmetric pairs, of balanced joints."""

import numpy as np
import pytest
from samples.fidelity_samples import Z, link, pendulum, planned_run

from plymotion.solver.studies.fidelity.answer import answer_text
from plymotion.solver.studies.fidelity.checked_run import checked, plan_of


def point(kind, at, component="z"):
    return {"kind": kind, "at": at, "component": component}


def reaction(joint, quantity, component):
    return {"kind": "reaction", "joint": joint, "quantity": quantity, "component": component}


def resultant(component, body="link0"):
    return {"kind": "resultant", "body": body, "x": 0.1, "component": component}


def difference(one, two):
    return {"kind": "difference", "of": one, "minus": two}


ACROSS = {
    "speed": point("velocity", "link1.tip"),
    "spin": point("angular_velocity", "link1.tip", "x"),
    "acceleration": point("acceleration", "link1.tip"),
    "force_z": reaction("hinge0", "force", "z"),
    "moment_x": reaction("hinge0", "moment", "x"),
    "shear": resultant("F3"),
    "torque": resultant("M1"),
    "bend": resultant("M2"),
    "turned": point("orientation", "link1.tip", "y"),
}


def symmetric():
    """Two opposite arms on a driven hub: the force on its bearing is zero, and what differs."""
    table = pendulum(links=2)
    arms = {"link0": link(0.6, 0.1), "link1": {**link(0.6, -0.1), "rotation_deg": [0, 0, 180.0]}}
    places = {"axis": 0.0, "one": 0.1, "two": -0.1}
    hub = {
        "kind": "rigid",
        "mass": 1.0,
        "inertia": [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]],
        "interfaces": {name: {"position": [x, 0.0, 0.0]} for name, x in places.items()},
    }
    drive = {"polynomial": [0.0, 0.0, 10.0]}
    signals = {
        "bearing": reaction("bearing", "force", "x"),
        "deflection0": {**point("deflection", "link0.tip", "y"), "seen_from": "link0.root"},
        "deflection1": {**point("deflection", "link1.tip", "y"), "seen_from": "link1.root"},
        "moment0": resultant("M3"),
        "moment1": resultant("M3", "link1"),
        "force0": reaction("clamp0", "force", "magnitude"),
        "force1": reaction("clamp1", "force", "magnitude"),
        **{f"d_{n}": difference(f"{n}0", f"{n}1") for n in ("deflection", "moment", "force")},
    }
    return {
        **table,
        "gravity": [0.0, 0.0, 0.0],
        "bodies": {"hub": hub, **arms},
        "joints": {
            "bearing": {
                "kind": "revolute",
                "between": ["ground.origin", "hub.axis"],
                "axis": Z,
                "drive": drive,
            },
            "clamp0": {"kind": "fixed", "between": ["hub.one", "link0.root"]},
            "clamp1": {"kind": "fixed", "between": ["hub.two", "link1.root"]},
        },
        "masses": {},
        "signals": signals,
        "solver": {"t_end": 0.1, "output_step": 1e-3, "start": "quasi-static"},
    }


def asked(table, *names):
    table["fidelity"] = {"accuracy": 1e-2, "signals": [*names], "budget": 60.0}
    return checked(plan_of(*planned_run(table, "stiff")))


@pytest.mark.parametrize(
    "names", [["speed"], ["moment_x"], [*ACROSS]], ids=["motion", "reaction", "all"]
)
def test_signals_across_the_plane_of_a_mechanism_are_met(names: list[str]) -> None:
    """A motion alone, a reaction alone, and all together: each is judged by a size of its own."""
    table = pendulum(links=2, t_end=0.15)
    table["signals"] = ACROSS
    table["solver"]["start"] = "quasi-static"
    answer = asked(table, *names)
    assert answer.verdict == "met", answer.reason
    assert answer.check is not None
    assert len(answer.check.sizes) == len(names)
    assert min(answer.check.sizes) > 0.0
    assert "zero to rounding or noise" in answer_text(answer)
    assert all(body.rigid for body in answer.plan.bodies.values())


@pytest.mark.parametrize("name", ["bearing", "d_deflection", "d_moment", "d_force"])
def test_what_a_symmetric_pair_cancels_is_met(name: str) -> None:
    answer = asked(symmetric(), name)
    assert answer.verdict == "met", answer.reason
    assert answer.check is not None
    assert answer.check.sizes[0] > 0.0


@pytest.mark.parametrize("name", ["force", "bending", "tip_x"])
def test_signals_that_are_small_but_real_keep_their_own_size(name: str) -> None:
    """A link whose motion is a millionth of the usual one, and the force of its own weight."""
    table = pendulum(speed=6e-6, t_end=0.1)
    table["gravity"] = [0.0, -9.81e-6, 0.0]
    table["signals"]["tip_x"] = point("velocity", "link0.tip", "y")
    answer = asked(table, name)
    assert answer.check is not None
    assert answer.check.sizes[0] == 0.0
    scale = answer.study.indicators.scale[0]
    assert scale == pytest.approx(np.abs(answer.check.signals[0]).max(), rel=0.5)


def test_a_difference_of_forces_is_judged_as_forces_are() -> None:
    """Its indicators follow from accelerations; by the modes alone each would be zero."""
    table = pendulum(links=2, t_end=0.1)
    table["signals"]["inner"] = reaction("hinge1", "force", "x")
    table["signals"]["d"] = difference("force", "inner")
    both = [plan_of(*planned_run({**table, "fidelity": {"accuracy": 1e-2, "signals": [n]}}))
            for n in ("force", "d")]  # fmt: skip
    largest = [np.abs(a.study.indicators.effects.response).max() for a in both]
    assert largest[1] > 0.01 * largest[0] > 0.0
