"""Parts of the scenes of the benchmark of [fidelity]: materials, beams, signals, a case."""

from typing import Any

Table = dict[str, Any]

ALUMINIUM: Table = {"kind": "isotropic", "E": 73e9, "nu": 0.3, "rho": 2700.0}
STEEL: Table = {"kind": "isotropic", "E": 210e9, "nu": 0.3, "rho": 7850.0}
CARBON: Table = {
    "kind": "orthotropic",
    "E1": 129.2e9,
    "E2": 9.4e9,
    "E3": 9.4e9,
    "G12": 5.2e9,
    "G13": 4.3e9,
    "G23": 2.5e9,
    "nu12": 0.3,
    "nu13": 0.3,
    "nu23": 0.22,
    "rho": 1550.0,
}
MATERIALS = {"aluminium": ALUMINIUM, "steel": STEEL, "carbon": CARBON}
FLAT = [0.0, 0.0, 1.0]  # the width of the section across the plane of motion: the soft side
ENDS = {"root": {"at": "start"}, "mid": {"at": 0.5}, "tip": {"at": "end"}}
Z = [0.0, 0.0, 1.0]


def beam(
    length: float,
    at: list[float],
    *,
    material: str = "aluminium",
    soft: bool = False,
    angle: float | None = None,
    turned_deg: float = 0.0,
    **more: Any,
) -> Table:
    """A beam of the section "bar" along the direction `turned_deg` in the plane."""
    body: Table = {
        "kind": "beam",
        "length": length,
        "section": "bar",
        "material": material,
        "elements": 24,
        "modes": [{"kind": "bending-xy", "count": 2}],  # the plan has its own
        "position": at,
        "rotation_deg": [0.0, 0.0, turned_deg],
        "interfaces": ENDS,
        **more,
    }
    if soft:
        body["x2_axis"] = FLAT
    if angle is not None:
        body["ply_angle_deg"] = angle
    return body


def revolute(one: str, two: str, axis: list[float] = Z, **more: Any) -> Table:
    """A revolute joint between two interfaces; `more` may have its drive."""
    return {"kind": "revolute", "between": [one, two], "axis": axis, **more}


def universal(one: str, two: str) -> Table:
    """A universal joint with one axis across the plane of motion, which closes a planar loop."""
    return {"kind": "universal", "between": [one, two], "axis": Z, "axis_2": [0.0, 1.0, 0.0]}


def signals(last: str, joint: str, first: str, plane: str = "y") -> dict[str, Table]:
    """The four kinds of output: tip, own deflection, joint force, moment in the first body."""
    return {
        "tip": {"kind": "position", "at": f"{last}.tip", "component": "y"},
        "deflection": {
            "kind": "deflection",
            "at": f"{first}.tip",
            "seen_from": f"{first}.root",
            "component": plane,
        },
        "force": {"kind": "reaction", "joint": joint, "quantity": "force", "component": "x"},
        "moment": {"kind": "resultant", "body": first, "x": 0.1, "component": "M3"},
    }


def case(bodies: Table, joints: Table, found: Table, t_end: float, **more: Any) -> Table:
    """A case with gravity along -y, a bar of 40 x 10 mm unless `more` says otherwise."""
    used = {body["material"] for body in bodies.values() if "material" in body}
    return {
        "format": 1,
        "title": "scene of the benchmark of [fidelity]",
        "gravity": [0.0, -9.81, 0.0],
        "materials": {name: MATERIALS[name] for name in used},
        "sections": {"bar": {"shape": "rectangle", "width": 0.04, "height": 0.01}},
        "bodies": bodies,
        "joints": joints,
        "signals": found,
        "solver": {"t_end": t_end, "output_step": t_end / 500.0},
        **more,
    }


def arm_with_wrist(upper: Table, hand: float, speed: float, t_end: float, mass: float) -> Table:
    """An arm in space: its upper link turns about an axis across it while a rigid hand swings."""
    inertia = [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]]
    origin = {"position": [0.0, 0.0, 0.0]}
    bodies = {
        "upper": upper,
        "lower": {
            "kind": "rigid",
            "mass": mass,
            "centre": [hand / 2.0, 0.0, 0.0],
            "inertia": inertia,
            "position": [upper["length"], 0.0, 0.0],
            "interfaces": {"root": origin, "tip": {"position": [hand, 0.0, 0.0]}},
        },
    }
    drive = {"polynomial": [0.0, 0.0, speed / (2 * t_end)]}
    joints = {
        "shoulder": revolute("ground.origin", "upper.root", [0.0, 1.0, 0.0], drive=drive),
        "wrist": revolute("upper.tip", "lower.root"),
    }
    found = signals("lower", "shoulder", "upper", "z")
    found["moment"]["component"] = "M2"
    return case(bodies, joints, found, t_end, ground={"origin": origin})
