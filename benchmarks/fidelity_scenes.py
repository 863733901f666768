"""Scenes of the benchmark of [fidelity].

The list was frozen before the rules of the planner were tuned. TUNING are the scenes that were
looked at while tuning; the others, HELD, were not. ADDED came later, frozen before it was run.
"""

from math import cos, pi
from typing import Any

from fidelity_added import ADDED
from fidelity_parts import Table, arm_with_wrist, beam, case, revolute, signals, universal


def pendulum(
    links: int = 2, speed: float = 8.0, t_end: float = 0.8, mass: float = 1.0, **of_beam: Any
) -> Table:
    """A chain of links, the first one driven at a speed, a mass at the tip."""
    length = 1.2 / links
    bodies = {f"link{i}": beam(length, [i * length, 0.0, 0.0], **of_beam) for i in range(links)}
    joints: Table = {
        "hinge0": revolute(
            "ground.origin", "link0.root", drive={"polynomial": [0.0, 0.0, speed / (2 * t_end)]}
        )
    }
    for i in range(1, links):
        places = [f"link{i - 1}.tip", f"link{i}.root"]
        joints[f"hinge{i}"] = revolute(*places)
    last = f"link{links - 1}"
    found = signals(last, "hinge0", "link0")
    moment = found["moment"]
    moment["component"] = "M2" if of_beam.get("soft") else "M3"
    return case(
        bodies,
        joints,
        found,
        t_end,
        ground={"origin": {"position": [0.0, 0.0, 0.0]}},
        masses={"load": {"mass": mass, "at": f"{last}.tip"}},
    )


def slider_crank(speed: float = 40.0, t_end: float = 0.3, **of_rod: Any) -> Table:
    """A rigid crank, a flexible rod and a rigid slider and a guide."""
    r, length = 0.12, 0.5
    inertia = [[1e-4, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]]
    bodies = {
        "crank": {
            "kind": "rigid",
            "mass": 0.3,
            "centre": [r / 2, 0.0, 0.0],
            "inertia": inertia,
            "interfaces": {
                "root": {"position": [0.0, 0.0, 0.0]},
                "tip": {"position": [r, 0.0, 0.0]},
            },
        },
        "rod": beam(length, [r, 0.0, 0.0], **of_rod),
        "slider": {
            "kind": "rigid",
            "mass": 0.5,
            "inertia": inertia,
            "position": [r + length, 0.0, 0.0],
            "interfaces": {"pin": {"position": [0.0, 0.0, 0.0]}},
        },
    }
    joints = {
        "motor": revolute("ground.origin", "crank.root", drive={"speed": speed}),
        "big_end": {"kind": "spherical", "between": ["crank.tip", "rod.root"]},
        "small_end": universal("rod.tip", "slider.pin"),
        "guide": {
            "kind": "prismatic",
            "between": ["ground.rail", "slider.pin"],
            "axis": [1.0, 0.0, 0.0],
        },
    }
    found = signals("rod", "motor", "rod")
    found["tip"] = {"kind": "position", "at": "rod.mid", "component": "y"}
    found["deflection"]["at"] = "rod.mid"
    found["moment"]["component"] = "M2" if of_rod.get("soft") else "M3"
    found["moment"]["x"] = 0.25
    return case(
        bodies,
        joints,
        found,
        t_end,
        ground={
            "origin": {"position": [0.0, 0.0, 0.0]},
            "rail": {"position": [r + length, 0.0, 0.0]},
        },
    )


def spin_up(speed: float = 6.0, t_end: float = 2.0, length: float = 8.0, **of_beam: Any) -> Table:
    """A long slender beam that is brought to a speed: it needs geometric stiffening."""
    found = signals("blade", "hub", "blade")
    drive = {"polynomial": [0.0, 0.0, 0.0, speed / (3 * t_end**2)]}
    made = case(
        {"blade": beam(length, [0.0, 0.0, 0.0], **of_beam)},
        {"hub": revolute("ground.origin", "blade.root", drive=drive)},
        found,
        t_end,
        ground={"origin": {"position": [0.0, 0.0, 0.0]}},
        sections={"bar": {"shape": "rectangle", "width": 0.08, "height": 0.0368}},
    )
    made["gravity"] = [0.0, 0.0, 0.0]
    return made


def arm(speed: float = 3.0, t_end: float = 0.8, mass: float = 1.0, angle: float = 30.0) -> Table:
    """A laminated arm in space: it turns about the vertical while its wrist swings."""
    upper = beam(0.6, [0.0, 0.0, 0.0], material="carbon", angle=angle)
    return arm_with_wrist(upper, 0.4, speed, t_end, mass)


def resonance(ratio: float = 1.0, t_end: float = 1.0, **of_beam: Any) -> Table:
    """A cantilever whose root is shaken near its first frequency."""
    frequency = 13.1 * ratio  # the first one of this bar is 13.1 Hz
    times = [t_end * k / 400.0 for k in range(401)]
    values = [0.002 * (1.0 - cos(2.0 * pi * frequency * time)) for time in times]
    drive = {"table": {"times": times, "values": values}}
    length = 0.8
    made = case(
        {"bar": beam(length, [0.0, 0.0, 0.0], soft=True, **of_beam)},
        {
            "shaker": {
                "kind": "prismatic",
                "between": ["ground.origin", "bar.root"],
                "axis": [0.0, 1.0, 0.0],
                "drive": drive,
            }
        },
        signals("bar", "shaker", "bar"),
        t_end,
        ground={"origin": {"position": [0.0, 0.0, 0.0]}},
    )
    made["signals"]["force"]["component"] = "y"
    made["signals"]["moment"]["component"] = "M2"
    return made


TUNING: dict[str, Table] = {
    "pendulum-aluminium": pendulum(),
    "pendulum-soft": pendulum(soft=True, speed=4.0),
    "pendulum-carbon": pendulum(material="carbon", angle=30.0),
    "one-link": pendulum(links=1, speed=10.0),
    "slider-crank": slider_crank(),
    "slider-crank-soft": slider_crank(soft=True, speed=30.0),
    "chain-of-four": pendulum(links=4, speed=5.0, t_end=0.6),
    "spin-up": spin_up(),
    "arm": arm(),
    "resonance": resonance(),
}
HELD: dict[str, Table] = {
    "pendulum-steel": pendulum(material="steel", speed=12.0),
    "pendulum-heavy": pendulum(mass=4.0, soft=True, speed=3.0),
    "pendulum-carbon-soft": pendulum(material="carbon", angle=45.0, soft=True, speed=5.0),
    "one-link-soft": pendulum(links=1, speed=6.0, soft=True),
    "slider-crank-carbon": slider_crank(material="carbon", angle=0.0, soft=True, speed=50.0),
    "slider-crank-slow": slider_crank(speed=15.0, t_end=0.6),
    "chain-of-three": pendulum(links=3, speed=6.0, t_end=0.7, soft=True),
    "spin-up-short": spin_up(length=6.0, speed=8.0, t_end=1.5),
    "arm-heavy": arm(mass=3.0, speed=2.0, angle=15.0),
    "off-resonance": resonance(ratio=0.6),
    **ADDED,
}
SCENES = {**TUNING, **HELD}
