"""Scenes whose signals depend on two ply angles, for benchmarks/design.py."""

from collections.abc import Callable
from typing import Any

from tests.samples.design_samples import CARBON, STRENGTH, angles, tube

Table = dict[str, Any]
Scene = Callable[[Table], None]
SCENES: dict[str, Scene] = {}
PLACES = {"between": ["ground.base", "arm.root"]}
Y, Z = [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]


def scene(change: Scene) -> Scene:
    """Register a scene: what it changes of `hinged`."""
    SCENES[change.__name__] = change
    return change


def hinged() -> Table:
    """Two plies of a box, of different angles, that falls about a hinge with 0.5 kg at its tip."""
    table = tube(2, parameters=angles(2), studies={})
    table["materials"] = {"carbon": {**CARBON, "strength": STRENGTH}}
    description = table["sections"]["tube"]["description"]
    description["mesh"] = {"shape": "box", "width": 0.024, "height": 0.014}
    description["regions"] = {
        wall: {"laminate": "wall"} for wall in ("top", "bottom", "left", "right")
    }
    table["gravity"] = [0.0, 0.0, -9.81]
    table["bodies"]["arm"]["damping_ratio"] = 0.02
    table["bodies"]["arm"]["modes"] = [{"kind": "lowest", "count": 6}]
    table["masses"] = {"load": {"mass": 0.5, "at": "arm.tip"}}
    table["joints"]["root"] |= {"kind": "revolute", "axis": Y}
    table["ground"]["above"] = {"position": [0.6, 0.0, 0.5]}
    table["signals"] = {
        "tip": {"kind": "deflection", "at": "arm.tip", "component": "z"},
        "aside": {"kind": "deflection", "at": "arm.tip", "component": "y"},
        "turned": {"kind": "rotation", "at": "arm.tip", "component": "x"},
    }
    table["solver"] = {"t_end": 0.2, "output_step": 0.005, "integrator": "radau", "rtol": 1e-10}
    return table


def clamped(table: Table) -> None:
    """Fix the root; loads across the box do not twist it."""
    del table["signals"]["turned"]
    table["joints"]["root"] = {"kind": "fixed", "between": ["ground.base", "arm.root"]}


def pushed(table: Table, /, **law: Any) -> None:
    """Apply a force at the tip."""
    direction = [0.0, 0.6, 0.8]
    push = {"kind": "force", "at": "arm.tip", "direction": direction, "law": law}
    table["forces"] = {"push": push}


def driven(table: Table, /, **drive: Any) -> None:
    """Prescribe the angle of the hinge."""
    table["joints"]["root"]["drive"] = drive


def second(table: Table, joint: Table) -> None:
    """Another arm of the same section at the tip of the first."""
    table["bodies"]["fore"] = {**table["bodies"]["arm"], "length": 0.4, "position": [0.6, 0.0, 0.0]}
    table["joints"]["elbow"] = {"between": ["arm.tip", "fore.root"], **joint}
    table["signals"]["fore"] = {"kind": "deflection", "at": "fore.tip", "component": "z"}


@scene
def falling(table: Table) -> None: ...


@scene
def smooth_drive(table: Table) -> None:
    driven(table, smooth_step={"start": 0.0, "duration": 0.1, "value": -0.3})


@scene
def table_drive(table: Table) -> None:
    driven(table, table={"times": [0.0, 0.07, 0.13, 0.3], "values": [0.0, 0.1, -0.2, 0.1]})


@scene
def cantilever_by_expression(table: Table) -> None:
    clamped(table)
    pushed(table, expression="20 * sin(60 * t) * exp(-5 * t)")


@scene
def cantilever_by_table(table: Table) -> None:
    clamped(table)
    law = {"times": [0.0, 0.05, 0.1, 0.4], "values": [0.0, 30.0, -20.0, 5.0]}
    pushed(table, table={**law, "interpolation": "linear"})


@scene
def equilibrium_then_load(table: Table) -> None:
    clamped(table)
    pushed(table, expression="15 * (t > 0.04)")
    table["solver"]["start"] = "equilibrium"


@scene
def spring_and_damper(table: Table) -> None:
    spring = {"kind": "spring", "between": ["ground.above", "arm.tip"], "stiffness": 200.0}
    table["forces"] = {"spring": {**spring, "damping": 2.0, "length": 0.4}}


@scene
def hanging_in_equilibrium(table: Table) -> None:
    pushed(table, expression="20 * sin(30 * t)")
    push = table["forces"]["push"]
    twist = {**push, "kind": "torque", "direction": [1.0, 0.0, 0.0]}
    spring_and_damper(table)
    table["forces"] |= {"push": push, "twist": twist}
    table["solver"]["start"] = "equilibrium"


@scene
def rotary_spring(table: Table) -> None:
    table["forces"] = {"spring": {"kind": "rotary_spring", **PLACES, "axis": Y, "stiffness": 100.0}}


@scene
def controlled(table: Table) -> None:
    pid = {"joint": "root", "proportional": 150.0, "derivative": 6.0, "integral": 40.0}
    table["forces"] = {"motor": {"kind": "controller", **pid, "setpoint": "0.2 * sin(15 * t)"}}


@scene
def controlled_by_samples(table: Table) -> None:
    controlled(table)
    gains = {"proportional": 20.0, "derivative": 0.0, "integral": 10.0}
    table["forces"]["motor"] |= {**gains, "sample_time": 0.002}


@scene
def friction(table: Table) -> None:
    table["forces"] = {
        "brake": {
            "kind": "friction", "joint": "root", "coulomb": 1.0, "rest_velocity": 0.2,
            "viscous": 0.1,
        }
    }  # fmt: skip


@scene
def elastic_stop(table: Table) -> None:
    stop = {"kind": "limit_stop", "joint": "root", "upper": 0.1, "stiffness": 500.0}
    table["forces"] = {"stop": {**stop, "exponent": 1.0}}


@scene
def bushing(table: Table) -> None:
    del table["joints"]["root"]
    table["forces"] = {
        "bushing": {
            "kind": "bushing", **PLACES,
            "stiffness": [1e5, 1e5, 1e5], "rotary_stiffness": [200.0, 200.0, 200.0],
            "damping": [10.0, 10.0, 10.0], "rotary_damping": [0.1, 0.1, 0.1],
        }
    }  # fmt: skip


@scene
def spun_up(table: Table) -> None:
    table["joints"]["root"]["axis"] = Z
    driven(table, ramp={"speed": 20.0, "duration": 0.2})
    table["solver"]["geometric_stiffening"] = True


@scene
def steady_spin(table: Table) -> None:
    table["joints"]["root"] |= {"axis": Z, "drive": {"polynomial": [0.0, 12.0]}}
    table["solver"]["geometric_stiffening"] = True
    table["solver"] |= {"start": "equilibrium", "spin": {"speed": 12.0, "axis": Z}}
    pushed(table, expression="10 * sin(40 * t)")


@scene
def double_pendulum(table: Table) -> None:
    second(table, {"kind": "revolute", "axis": Y})


@scene
def double_pendulum_in_space(table: Table) -> None:
    second(table, {"kind": "spherical"})
    table["gravity"] = [0.0, 4.0, -9.0]


@scene
def slider_crank(table: Table) -> None:
    """The arm is the rod of a crank of 0.1 m."""
    unit = [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]]
    place = {"position": [0.0, 0.0, 0.0]}
    table["masses"] = {}
    table["bodies"]["crank"] = {
        "kind": "rigid", "mass": 0.2, "inertia": unit,
        "interfaces": {"axle": {"position": [-0.1, 0.0, 0.0]}, "pin": place},
    }  # fmt: skip
    table["bodies"]["slider"] = {
        "kind": "rigid", "mass": 0.5, "inertia": unit, "position": [0.6, 0.0, 0.0],
        "interfaces": {"pin": place},
    }  # fmt: skip
    table["ground"] = {
        "axle": {"position": [-0.1, 0.0, 0.0]}, "rail": {"position": [0.6, 0.0, 0.0]}
    }  # fmt: skip
    table["joints"] = {
        "axle": {
            "kind": "revolute", "between": ["ground.axle", "crank.axle"], "axis": Y,
            "drive": {"ramp": {"speed": 30.0, "duration": 0.1}},
        },
        "pin": {"kind": "revolute", "between": ["crank.pin", "arm.root"], "axis": Y},
        "rail": {
            "kind": "prismatic", "between": ["ground.rail", "slider.pin"], "axis": [1.0, 0.0, 0.0]
        },
        "end": {"kind": "point_on_line", "between": ["slider.pin", "arm.tip"], "axis": Y},
    }  # fmt: skip


@scene
def stresses(table: Table) -> None:
    """Signals of plies, sections and joints of the driven arm; maxima over plies have kinks."""
    smooth_drive(table)
    table["signals"] = {
        "moment": {"kind": "resultant", "body": "arm", "x": 0.1, "component": "M2"},
        "force": {
            "kind": "reaction", "joint": "root", "quantity": "force", "component": "z"
        },
        "torque": {
            "kind": "reaction", "joint": "root", "quantity": "moment", "component": "y"
        },
        "fibre": {
            "kind": "ply_stress", "body": "arm", "x": 0.1, "region": "top", "ply": 1,
            "component": "11", "point": [0.0, 0.007],
        },
    }  # fmt: skip
