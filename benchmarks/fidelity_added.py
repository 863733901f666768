"""Scenes that were added to the benchmark of [fidelity] later, of kinds that it did not have.

Frozen on 2026-11-22, in the commit that added this file: before any of them was run, and before
the rules of the planner were changed again. They are held back like HELD of fidelity_scenes.py.
`blade-push`, shorter and thicker, was added after the others and frozen in the same way: the truth
of `blade-pulse` had stopped at a buckling load. Its push was a cubic spline then, which went far
beyond its points after the push; tables of loads are straight lines now (docs/adr/0049).
"""

from math import acos, atan2, cos, degrees, hypot, pi, sin

from fidelity_parts import (
    CARBON,
    FLAT,
    Table,
    Z,
    arm_with_wrist,
    beam,
    case,
    revolute,
    signals,
    universal,
)

INERTIA = [[1e-4, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]]
CROSS_PLY = [0.0, 90.0, 0.0, 0.0, 0.0, 0.0, 90.0, 0.0]
ORIGIN = {"position": [0.0, 0.0, 0.0]}


def laminated(mesh: Table, angles_deg: list[float], thickness: float) -> Table:
    """A section of carbon plies; one angle on top and bottom points to the same side."""
    plies = {"material": "carbon", "angles_deg": angles_deg, "ply_thickness": thickness}
    description = {
        "convention": "cartesian",
        "mesh": mesh,
        "materials": {"carbon": CARBON},
        "laminates": {"wall": plies},
        "regions": {"all": {"laminate": "wall"}},
    }
    return {"description": description}


def described(length: float, at: list[float], turned_deg: float = 0.0, **more: object) -> Table:
    """A beam of the section "laminate", which has materials of its own."""
    body = beam(length, at, turned_deg=turned_deg, **more)
    del body["material"]
    return {**body, "section": "laminate"}


def four_bar(speed: float = 20.0, t_end: float = 0.35) -> Table:
    """A rigid crank, a coupler of a cross-ply strip, a rocker of aluminium, all in a plane."""
    crank, coupler, rocker, ground = 0.12, 0.5, 0.3, 0.45
    across = ground - crank
    angle = acos((coupler**2 + across**2 - rocker**2) / (2.0 * coupler * across))
    end = [crank + coupler * cos(angle), coupler * sin(angle)]
    of_rocker = degrees(atan2(end[1], end[0] - ground))
    assert abs(hypot(end[0] - ground, end[1]) - rocker) < 1e-12
    bodies = {
        "crank": {
            "kind": "rigid",
            "mass": 0.3,
            "centre": [crank / 2, 0.0, 0.0],
            "inertia": INERTIA,
            "interfaces": {"root": ORIGIN, "tip": {"position": [crank, 0.0, 0.0]}},
        },
        "coupler": described(coupler, [crank, 0.0, 0.0], degrees(angle), x2_axis=FLAT),
        "rocker": beam(rocker, [ground, 0.0, 0.0], soft=True, turned_deg=of_rocker),
    }
    joints = {
        "motor": revolute("ground.origin", "crank.root", drive={"speed": speed}),
        "near": {"kind": "spherical", "between": ["crank.tip", "coupler.root"]},
        "far": universal("coupler.tip", "rocker.tip"),
        "pivot": revolute("ground.pivot", "rocker.root"),
    }
    found = signals("coupler", "motor", "coupler")
    found["tip"]["at"] = found["deflection"]["at"] = "coupler.mid"
    found["moment"] = {**found["moment"], "x": 0.25, "component": "M2"}
    places = {"origin": ORIGIN, "pivot": {"position": [ground, 0.0, 0.0]}}
    made = case(bodies, joints, found, t_end, ground=places)
    strip = {"shape": "rectangle", "width": 0.04, "height": 0.008}
    made["sections"]["laminate"] = laminated(
        strip, [0.0, 90.0, 0.0, 0.0, 0.0, 0.0, 90.0, 0.0], 1e-3
    )
    return made


def blade_pulse(
    speed: float = 40.0,
    push: float = 3.0,
    t_end: float = 0.5,
    length: float = 0.9525,
    height: float = 0.0029718,
) -> Table:
    """A blade on a rigid hub at constant speed; a push at the tip lets it flap."""
    offset, begin, duration = 0.0635, 0.05, 0.05
    times = [begin + duration * i / 20.0 for i in range(21)]
    values = [0.5 * push * (1.0 - cos(2.0 * pi * i / 20.0)) for i in range(21)]
    bodies = {
        "hub": {
            "kind": "rigid",
            "mass": 1.0,
            "inertia": INERTIA,
            "interfaces": {"axis": ORIGIN, "rim": {"position": [offset, 0.0, 0.0]}},
        },
        "blade": beam(length, [offset, 0.0, 0.0], material="carbon", angle=0.0),
    }
    joints = {
        "axis": revolute("ground.axis", "hub.axis", drive={"speed": speed}),
        "clamp": {"kind": "fixed", "between": ["hub.rim", "blade.root"]},
    }
    found = signals("blade", "clamp", "blade", "z")
    found["tip"]["component"] = found["force"]["component"] = "z"
    found["moment"]["component"] = "M2"
    law = {"table": {"times": [0.0, *times, t_end], "values": [0.0, *values, 0.0]}}
    flap = {"kind": "force", "at": "blade.tip", "direction": Z, "law": law}
    made = case(bodies, joints, found, t_end, ground={"axis": ORIGIN}, forces={"push": flap})
    made["gravity"] = [0.0, 0.0, 0.0]
    made["sections"] = {"bar": {"shape": "rectangle", "width": 0.0254, "height": height}}
    return made


def arm_box(speed: float = 3.0, t_end: float = 0.6, mass: float = 0.6) -> Table:
    """An arm of a box whose lay-up couples bending and twist, with a wrist that swings."""
    made = arm_with_wrist(described(0.6, [0.0, 0.0, 0.0]), 0.3, speed, t_end, mass)
    box = {"shape": "box", "width": 0.03, "height": 0.012}
    made["sections"] = {"laminate": laminated(box, [20.0, 20.0, 20.0, 20.0], 0.127e-3)}
    return made


ADDED: dict[str, Table] = {
    "four-bar": four_bar(),
    "blade-pulse": blade_pulse(),
    "arm-box": arm_box(),
    "blade-push": blade_pulse(length=0.6, height=0.004, push=2.0, t_end=0.3),
}
