"""The case of a robot: links as rigid bodies, joints, stops, friction, couplings, signals.

Bodies have the axes of their links, and the case stands at q = 0 of all joints. Links on fixed
joints are parts of the body that they are fixed to.
"""

import re
import unicodedata
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from ...dynamics.elements.forces import rotary_spring
from ...dynamics.elements.forces.controller import CONTROLLER
from ...dynamics.elements.forces.friction import FRICTION
from ...dynamics.elements.forces.limit_stop import LIMIT_STOP
from ...errors import InputError, nearest, refuse
from ...math.arrays import Array
from ...math.rotations import matrix_to_vector
from ..tolerances import CLEAR, DEGREES, DENSE, LIGHT, LONG, MANY_TURNS, SLIM, WIDE
from .urdf import HERE, Inertia, Pose, Robot, Type, UrdfJoint, about

Tables = dict[str, Any]
Moved = Literal["hold", "motor", "free"]
Base = Literal["fixed", "free"]
GROUND = "ground"
SINGLE = (Type.REVOLUTE, Type.CONTINUOUS, Type.PRISMATIC)
TRIANGLE = 1e-5  # relative, of principal moments: that of the check of a case
STOP_DEPTH = 0.01  # at which a stop balances the effort of the drive [rad, m]
# Axes along which and about which joints move that are no hinges: 0 is that of the joint.
MOTIONS: dict[str, tuple[list[int], list[int]]] = {
    Type.PRISMATIC: ([0], []),
    Type.PLANAR: ([1, 2], [0]),
    Type.FLOATING: ([0, 1, 2], [0, 1, 2]),
    Type.FIXED: ([], []),
}
SINGULAR = 1e-12  # least eigenvalue of a mass matrix with a diagonal of 1
REST = 0.01  # speed below which the direction of friction is smoothed [rad/s, m/s]


@dataclass
class Body:
    """Links that are fixed to each other.

    Attributes
    ----------
    head : link whose axes it has
    pose : of the head at q = 0, global
    links : link -> pose in the head
    """

    head: str
    pose: Pose
    inertia: Inertia
    links: dict[str, Pose] = field(default_factory=dict)


@dataclass(frozen=True)
class RobotCase:
    """A robot as tables of a case.

    Attributes
    ----------
    tables : of the case file
    bodies : by name in the case; "ground" is the base, where it stands
    names : names in the case of links and joints
    notes : what the case does not have of the file, one line each
    """

    tables: Tables
    bodies: dict[str, Body]
    names: dict[str, str]
    notes: list[str]


def robot_case(
    robot: Robot,
    *,
    joints: Moved = "hold",
    base: Base = "fixed",
    keep_fixed: bool = False,
    allow: Collection[str] = (),
) -> RobotCase:
    """Return the case of a robot.

    Parameters
    ----------
    joints : hold: drives hold the coordinates; motor: an actuator in each joint; free: neither
    base : whether the root link is the ground, or a body that moves freely
    keep_fixed : links with mass on fixed joints stay bodies, with a fixed joint
    allow : "inertia": principal moments that no solid has; "units": doubtful sizes

    Raises
    ------
    InputError
        One line per mistake: file and line, element, value, expectation.
    """
    for key, value, known in (("joints", joints, Moved), ("base", base, Base)):
        if value not in get_args(known):
            raise InputError(f"{key} = {value!r}: expected one of {', '.join(get_args(known))}")
    heads, bodies = _bodies(robot, base == "free", keep_fixed)
    errors = [line for body in bodies.values() for line in _mistakes(robot, body, bodies, allow)]
    errors += [] if "units" in allow else _degrees(robot)
    errors += [] if {"inertia", "units"} & set(allow) else _dense(robot)
    errors = errors or _without_inertia(robot, heads, bodies)
    names = _names(robot, errors)
    refuse(errors)
    made = _Writer(robot, heads, bodies, names, joints)
    return made.case(allow)


def _bodies(
    robot: Robot, free: bool, keep_fixed: bool
) -> tuple[dict[str, tuple[str, Pose]], dict[str, Body]]:
    """Return head link and pose in it of each link, and the bodies by head; "" is the ground."""
    at_zero = {name: HERE for name in robot.links}
    heads = {robot.root: (robot.root if free else "", HERE)}
    bodies = {heads[robot.root][0]: Body(robot.root, HERE, robot.links[robot.root].inertia)}
    for joint in robot.joints.values():
        link = robot.links[joint.child]
        value = start(robot, joint)
        inside = joint.pose
        if value and joint.kind in SINGLE:
            inside = inside @ _moved(joint, value)
        at_zero[joint.child] = at_zero[joint.parent] @ inside
        kept = keep_fixed and link.inertia.mass > 0.0
        if joint.kind == Type.FIXED and not kept:
            head, pose = heads[joint.parent]
            heads[joint.child] = head, pose @ joint.pose
            body = bodies[head]
            body.inertia = body.inertia.plus(link.inertia.seen_from(heads[joint.child][1]))
        else:
            heads[joint.child] = joint.child, HERE
            bodies[joint.child] = Body(joint.child, at_zero[joint.child], link.inertia)
    for name, (head, pose) in heads.items():
        bodies[head].links[name] = pose
    return heads, bodies


def start(robot: Robot, joint: UrdfJoint) -> float:
    """Return the coordinate of a joint where all that mimic none are 0 [rad, m]."""
    value, factor = 0.0, 1.0
    while joint.mimic is not None and joint.kind != Type.FIXED:
        value += factor * joint.mimic.offset
        factor *= joint.mimic.multiplier
        joint = robot.joints[joint.mimic.joint]
    return value


def _moved(joint: UrdfJoint, value: float) -> Pose:
    if joint.kind == Type.PRISMATIC:
        return Pose(value * joint.axis, np.eye(3))
    return Pose(np.zeros(3), about(joint.axis, value))


def _mistakes(
    robot: Robot, body: Body, bodies: Mapping[str, Body], allow: Collection[str]
) -> list[str]:
    """Return what is wrong with the inertia of a moving body, one line each."""
    if bodies.get("") is body:
        return []
    link = robot.links[body.head]
    at = f"{robot.file}:{link.line}: <link {link.name}>: "
    mass, J = body.inertia.mass, body.inertia.about_centre
    a, b, c = (float(x) for x in np.linalg.eigvalsh(J))
    least, free = _least(body.inertia), "inertia" in allow
    if a < -least or (mass > 0.0 and a <= least and not free):
        return [
            f"{at}principal moments {a:.4g}, {b:.4g}, {c:.4g} kg m2; expected all above 0, or "
            "--allow inertia where joints hold what has none"
        ]
    errors = []
    if c > (a + b) * (1.0 + TRIANGLE) + least and not free:
        errors.append(
            f"{at}no solid has principal moments {a:.4g}, {b:.4g}, {c:.4g} kg m2; expected none "
            "above the sum of the other two, or --allow inertia"
        )
    if "units" not in allow and mass > 0.0:
        errors += [f"{at}{text}; or --allow units" for text in _doubts(robot, body, mass, c)]
    return errors


def _degrees(robot: Robot) -> list[str]:
    """Return a line for each hinge with limits that are none of a robot in rad."""
    return [
        f"{robot.file}:{joint.line}: <joint {joint.name}>, <limit>: {joint.lower:g} to "
        f"{joint.upper:g}: expected rad, found some like deg; or --allow units"
        for joint in robot.joints.values()
        if joint.kind == Type.REVOLUTE and joint.lower is not None and joint.upper is not None
        if MANY_TURNS < max(-joint.lower, joint.upper) <= DEGREES
    ]


def _dense(robot: Robot) -> list[str]:
    """Return a line if half of the mass of a robot is denser or lighter than robots are."""
    found = []
    for link in robot.links.values():
        mass, trace = link.inertia.mass, float(np.trace(link.inertia.about_centre))
        if min(mass, trace) > 0.0:
            # Of all solids with this mass and density, a ball has the least moments, 0.4 m r^2.
            volume = 4.0 / 3.0 * np.pi * (trace / (1.2 * mass)) ** 1.5
            found.append((mass / max(volume, 1e-300), mass, trace, link))
    found.sort(key=lambda each: each[0])
    half = 0.5 * sum(mass for _, mass, *_ in found)
    for density, mass, trace, link in found:
        half -= mass
        if half <= 0.0 and not LIGHT <= density <= DENSE:
            text = f"{mass:g} kg with moments of {trace:.3g} kg m2 in all: a ball with these has "
            text += f"{density:.3g} kg/m3; expected kg, m and kg m2, or --allow units"
            return [f"{robot.file}:{link.line}: <link {link.name}>: {text}"]
        if half <= 0.0:
            break
    return []


def _without_inertia(
    robot: Robot, heads: Mapping[str, tuple[str, Pose]], bodies: Mapping[str, Body]
) -> list[str]:
    """Return a line for a link that can move without inertia: M at q = 0 is singular."""
    above = {j.child: j for j in robot.joints.values() if heads[j.child][0] == j.child}
    owners, columns = list[str](), list[Array]()  # link; velocity at the origin, angular velocity
    moving = {head: body for head, body in bodies.items() if head}
    for head, body in moving.items():
        joint = above.get(head)  # none: a free root
        slides, turns = MOTIONS.get(joint.kind if joint else Type.FLOATING, ([], [0]))
        axes = np.linalg.svd((body.pose.A @ (joint.axis if joint else np.ones(3)))[None])[2]
        columns += [np.append(axes[k], np.zeros(3)) for k in slides]
        columns += [np.append(np.cross(body.pose.p, axes[k]), axes[k]) for k in turns]
        owners += [head] * len(slides + turns)
    n, whole = len(owners), np.array(columns).reshape(-1, 6)
    M, carried = np.zeros((n, n)), {"": np.zeros(n)}
    for head, body in moving.items():
        before = heads[above[head].parent][0] if head in above else ""
        carried[head] = carried[before] + [float(owner == head) for owner in owners]
        V, W = np.split(whole * carried[head][:, None], 2, axis=1)
        its = body.inertia.seen_from(body.pose)
        V = V + np.cross(W, its.centre)
        M += its.mass * V @ V.T + W @ its.about_centre @ W.T
    scale = np.sqrt(np.where(np.diag(M) > 0.0, np.diag(M), 1.0))
    values, vectors = np.linalg.eigh(M / np.outer(scale, scale))
    largest = np.argmax(np.abs(vectors[:, values <= SINGULAR]), axis=0) if n else ()
    return [
        f"{robot.file}:{robot.links[name].line}: <link {name}>: moves without inertia; expected "
        "<inertial> with a mass [kg] and moments [kg m2] above 0, here or in a link that it carries"
        for name in dict.fromkeys(owners[k] for k in largest)
    ]


def _least(inertia: Inertia) -> float:
    """Return what is rounding in moments of inertia [kg m2]: also of masses within 1e-6 m."""
    return max(1e-15 * float(np.abs(inertia.about_centre).max()), 1e-12 * inertia.mass)


def _doubts(robot: Robot, body: Body, mass: float, largest: float) -> list[str]:
    """Return what speaks for wrong units of a body."""
    below = [j.pose.p for j in robot.joints.values() if j.parent == body.head]
    centre = body.inertia.centre
    reach = max(float(np.linalg.norm(p - centre)) for p in [np.zeros(3), *below])
    radius = float(np.sqrt(largest / mass))
    size = f"with its joints {reach:.3g} m from the mass centre"
    if reach > LONG:
        return [f"{size}: expected lengths in m, found some like mm"]
    if radius < SLIM * reach:
        return [
            f"radius of gyration {radius:.3g} m {size}: the mass {mass:g} kg is too large, or the "
            f"inertia too small; expected kg and kg m2, radius at least {SLIM:g} of that distance"
        ]
    if reach > CLEAR and radius > WIDE * reach:
        return [
            f"radius of gyration {radius:.3g} m {size}: the mass {mass:g} kg is too small, or the "
            f"inertia too large; expected kg and kg m2, radius at most {WIDE:g} times that distance"
        ]
    return []


def _word(name: str, prefix: str) -> str:
    """Return a name of a case for one of a URDF."""
    # Accents leave their letters; a letter of another script becomes its number in Unicode.
    plain = "".join(c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))
    plain = "".join(c if c.isascii() else f"u{ord(c):x}" for c in plain)
    word = re.sub(r"[^A-Za-z0-9_-]", "_", plain)[:90]
    return word if word[:1].isalpha() and word != GROUND else f"{prefix}_{word}"


def _names(robot: Robot, errors: list[str]) -> dict[str, str]:
    """Return names of the case; `errors` gets those that two elements share."""
    names: dict[str, str] = {}
    for what, elements in (("link", robot.links), ("joint", robot.joints)):
        taken: dict[str, str] = {}
        for name, element in elements.items():
            word = _word(name, what)
            if word in taken:
                errors.append(
                    f"{robot.file}:{element.line}: <{what} {name}>: the same name in the case, "
                    f'"{word}", as {what} "{taken[word]}"; expected names that differ in letters, '
                    "digits, _ and -"
                )
            taken[word] = name
            names[f"{what} {name}"] = word
    return names


class _Writer:
    """Makes the tables of a case from a robot."""

    def __init__(
        self,
        robot: Robot,
        heads: Mapping[str, tuple[str, Pose]],
        bodies: Mapping[str, Body],
        names: Mapping[str, str],
        moved: Moved,
    ) -> None:
        self._robot, self._heads, self._bodies = robot, heads, bodies
        self._names, self._way = dict(names), moved
        self._notes = [*robot.notes]
        self._points: dict[str, Tables] = {head: {} for head in bodies}
        self._tables: Tables = {
            group: {} for group in ("bodies", "ground", "joints", "couplings", "forces", "signals")
        }

    def case(self, allow: Collection[str]) -> RobotCase:
        robot, tables = self._robot, self._tables
        for name in robot.reductions:
            if name not in robot.joints:
                near = nearest(name, robot.joints)
                self._notes.append(f"transmission of {name}: left out: no such joint{near}")
        for joint in robot.joints.values():
            self._joint(joint)
        for head, body in self._bodies.items():
            for link, pose in body.links.items():
                if link != body.head:
                    self._point(head, self._name("link", link), pose.p)
        named: dict[str, Body] = {}
        for head, body in self._bodies.items():
            if head == "":
                named[GROUND] = body
                for name, point in self._points[""].items():
                    tables["ground"][name] = point
                continue
            name = self._name("link", head)
            named[name] = body
            inertia = body.inertia.about_centre
            tables["bodies"][name] = {
                "kind": "rigid",
                "mass": body.inertia.mass,
                "centre": _numbers(body.inertia.centre),
                "inertia": [_numbers(row, _least(body.inertia)) for row in inertia],
                "position": _numbers(body.pose.p),
                "rotation_deg": _numbers(np.degrees(matrix_to_vector(body.pose.A))),
                "interfaces": self._points[head],
            }
        if not tables["bodies"]:
            raise InputError(
                f"{robot.file}: no link moves; expected a joint that is not fixed, or --base free"
            )
        top: Tables = {"format": 1, "title": robot.name, "gravity": [0.0, 0.0, -9.81]}
        if "inertia" in allow:
            top["allow"] = ["inertia"]
        whole = {
            **top,
            **{group: table for group, table in tables.items() if table},
            "solver": {"t_end": 1.0, "output_step": 0.01, "start": "quasi-static"},
            "runs": {"base": {}},
        }
        return RobotCase(whole, named, self._names, self._notes)

    def _name(self, what: str, name: str) -> str:
        return self._names[f"{what} {name}"]

    def _point(self, head: str, name: str, p: Array) -> str:
        """Add a place to a body; return its name."""
        points = self._points[head]
        while name in points:
            name += "_link"
        points[name] = {"position": _numbers(p)}
        return f"{self._name('link', head) if head else GROUND}.{name}"

    def _note(self, joint: UrdfJoint, text: str) -> None:
        file = self._robot.file.name
        self._notes.append(f"{file}:{joint.line}: <joint {joint.name}>: {text}")

    def _joint(self, joint: UrdfJoint) -> None:
        (one, pose), (two, _) = self._heads[joint.parent], self._heads[joint.child]
        if self._way == "hold" and joint.kind in (Type.FLOATING, Type.PLANAR):
            self._note(joint, f"no drive holds it: type {joint.kind}, of more than one coordinate")
        if one == two or joint.kind == Type.FLOATING:
            return
        name = self._name("joint", joint.name)
        places = [
            self._point(one, name, (pose @ joint.pose).p),
            self._point(two, name, np.zeros(3)),
        ]
        kind = Type.REVOLUTE if joint.kind == Type.CONTINUOUS else joint.kind
        table: Tables = {"kind": str(kind), "between": places}
        self._tables["joints"][name] = table
        if kind == Type.FIXED:
            return
        axis = table["axis"] = _numbers(self._bodies[two].pose.A @ joint.axis)
        if kind == Type.PLANAR:
            if joint.damping or joint.friction:
                self._note(joint, "no friction: only single coordinates have one")
            return
        of = {"joint": name}
        angle = {"kind": "joint", **of, "coordinate": "angle" if kind == Type.REVOLUTE else "z"}
        self._tables["signals"][f"{name}_q"] = angle
        first, low, high = start(self._robot, joint), joint.lower, joint.upper
        if low is not None and high is not None and low < high and not low <= first <= high:
            self._note(
                joint,
                f"stands at {first:g}, outside its limits {low:g} to {high:g}: expected a motion "
                "that begins within them; a stop pushes from the start",
            )
        mimic = joint.mimic
        if mimic is not None and self._robot.joints[mimic.joint].kind != Type.FIXED:
            self._couple(joint, mimic.joint, mimic.multiplier)
            if self._way != "hold":
                self._resist(joint)
        elif self._way == "hold" or mimic is not None:
            self._hold(joint, table)
        else:
            self._free(joint, places, axis)

    def _couple(self, joint: UrdfJoint, other: str, ratio: float) -> None:
        name, own = self._name("joint", joint.name), self._name("joint", other)
        slides = [k.kind == Type.PRISMATIC for k in (joint, self._robot.joints[other])]
        if slides == [True, False]:
            table = {"kind": "rack", "joints": [own, name], "radius": ratio}
        elif slides == [False, True]:
            table = {"kind": "rack", "joints": [name, own], "radius": 1.0 / ratio}
        else:
            kind = "slide_pair" if slides[0] else "gear_pair"
            table = {"kind": kind, "joints": [name, own], "ratio": ratio}
        self._tables["couplings"][f"{name}_mimic"] = table

    def _hold(self, joint: UrdfJoint, table: Tables) -> None:
        name = self._name("joint", joint.name)
        table["drive"] = {"polynomial": [0.0]}
        signal: Tables = {
            "kind": "reaction",
            "joint": name,
            "quantity": "force" if joint.kind == Type.PRISMATIC else "moment",
            "component": "z",
            "axes": "joint",
        }
        self._tables["signals"][f"{name}_drive"] = signal
        reduction = abs(self._robot.reductions.get(joint.name, 1.0))
        if reduction not in (0.0, 1.0):
            self._tables["signals"][f"{name}_motor"] = {
                **signal,
                "divide_by": reduction,
                "keep_unit": True,
                "description": f"torque of the motor, before its reduction of {reduction:g}",
            }

    def _free(self, joint: UrdfJoint, places: list[str], axis: list[float]) -> None:
        """Add what acts in a joint that no drive holds."""
        name, forces = self._name("joint", joint.name), self._tables["forces"]
        if self._way == "motor":
            if joint.kind == Type.PRISMATIC:
                self._note(joint, "no actuator: only rotations have one")
            else:
                forces[f"{name}_motor"] = {
                    "kind": rotary_spring.ELEMENT.kind,
                    "between": places,
                    "axis": axis,
                    "actuator": {"polynomial": [0.0]},
                }
        self._resist(joint)

    def _resist(self, joint: UrdfJoint) -> None:
        """Add friction, damping and stops of a joint."""
        name, forces = self._name("joint", joint.name), self._tables["forces"]
        if joint.friction > 0.0:
            forces[f"{name}_friction"] = {
                "kind": FRICTION.kind,
                "joint": name,
                "coulomb": joint.friction,
                "viscous": joint.damping,
                "rest_velocity": REST,
            }
        elif joint.damping > 0.0:
            forces[f"{name}_damping"] = {
                "kind": CONTROLLER.kind,
                "joint": name,
                "setpoint": "0",
                "derivative": joint.damping,
            }
        if joint.lower is None or joint.upper is None or not joint.effort > 0.0:
            return
        first, limits = start(self._robot, joint), f"{joint.lower:g} to {joint.upper:g}"
        room = _mimicked(self._robot, joint)
        if joint.lower == joint.upper:
            self._note(joint, f"no stops: its <limit> is {limits}")
        elif room and max(room[0], joint.lower) >= min(room[1], joint.upper):
            text = f"its limits {limits} leave no room to the joint that it mimics"
            self._note(joint, f"no stops: {text}")
        elif not room or room[0] < joint.lower or joint.upper < room[1]:
            forces[f"{name}_stop"] = {
                "kind": LIMIT_STOP.kind,
                "joint": name,
                "lower": joint.lower - first,
                "upper": joint.upper - first,
                "stiffness": joint.effort / STOP_DEPTH,
                "exponent": 1.0,
                "restitution": 0.5,
            }


def _mimicked(robot: Robot, joint: UrdfJoint) -> tuple[float, float] | None:
    """Return the range that stops of another joint leave to one that mimics it; None without.

    Two stops that meet, or that act at the same instant, have impacts that follow each other
    without end.
    """
    if joint.mimic is None:
        return None
    other, mimic = robot.joints[joint.mimic.joint], joint.mimic
    if other.lower is None or other.upper is None or other.lower == other.upper:
        return None
    if not other.effort > 0.0:
        return None
    first, last = sorted(mimic.offset + mimic.multiplier * x for x in (other.lower, other.upper))
    return first, last


def _numbers(values: Array, least: float = 1e-15) -> list[float]:
    """Return numbers without noise of rounding around zero."""
    return [0.0 if abs(x) < least else float(x) for x in values]
