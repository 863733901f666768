"""A URDF file as links and joints; each mistake is a line with file, line number and element.

The reader is our own (docs/adr, "URDF by a reader of our own"): libraries drop what they do not
know, or raise without a place in the file. Entities are refused, so that a file cannot grow.
"""

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from difflib import get_close_matches
from enum import StrEnum, auto
from pathlib import Path
from typing import TypeVar
from xml.parsers import expat

import numpy as np

from ...errors import InputError, did_you_mean, nearest, printable, refuse
from ...math.arrays import Array
from ...math.rotations import vector_to_matrix
from ..tolerances import FAR, TURNS

Thing = TypeVar("Thing")


class Type(StrEnum):
    """Types of joints in URDF."""

    REVOLUTE = auto()
    CONTINUOUS = auto()
    PRISMATIC = auto()
    PLANAR = auto()
    FLOATING = auto()
    FIXED = auto()


WITHOUT_AXIS = (Type.FIXED, Type.FLOATING)


class Dynamics(StrEnum):
    """Attributes of the element of this name."""

    DAMPING = auto()
    FRICTION = auto()


MESH = "mesh"
# Attributes of geometries, and how many numbers each has.
SIZES = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    MESH: {"scale": 3},
}
# Children that are read once, and attributes. A word that looks like one of them would be dropped.
KNOWN = {
    "link": ("inertial", "name"),
    "inertial": ("origin mass inertia", ""),
    "joint": ("origin parent child axis limit dynamics mimic", "name type"),
    "origin": ("", "xyz rpy"),
    "mass": ("", "value"),
    "inertia": ("", "ixx iyy izz ixy ixz iyz"),
    "parent": ("", "link"),
    "child": ("", "link"),
    "axis": ("", "xyz"),
    "limit": ("", "lower upper effort velocity"),
    "dynamics": ("", "damping friction"),
    "mimic": ("", "joint multiplier offset"),
}
ALIKE = 0.65  # of words: extensions of other programs look less like these
MOST_BYTES = 50_000_000


@dataclass
class Element:
    """An element of an XML file."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list["Element"] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> list["Element"]:
        """Return its children of a tag."""
        return [child for child in self.children if child.tag == tag]

    def one(self, tag: str) -> "Element | None":
        """Return its first child of a tag."""
        return next(iter(self.all(tag)), None)


@dataclass(frozen=True)
class Pose:
    """A frame in another one: x_other = p + A x."""

    p: Array  # (3,) [m]
    A: Array  # (3, 3)

    def __matmul__(self, inner: "Pose") -> "Pose":
        return Pose(self.p + self.A @ inner.p, self.A @ inner.A)


HERE = Pose(np.zeros(3), np.eye(3))


@dataclass(frozen=True)
class Shape:
    """A `visual` of a link: box, cylinder, sphere or mesh, in the frame of the link."""

    pose: Pose
    kind: str
    sizes: tuple[float, ...]  # edges; radius, length; radius; factors of a mesh
    file: str
    line: int


@dataclass(frozen=True)
class Inertia:
    """Mass [kg], centre (3,) [m] and inertia (3, 3) about the centre [kg m2], axes of the link."""

    mass: float
    centre: Array
    about_centre: Array

    def seen_from(self, pose: Pose) -> "Inertia":
        """Return the same in the frame in which the link has this pose."""
        turned = pose.A @ self.about_centre @ pose.A.T
        return Inertia(self.mass, pose.p + pose.A @ self.centre, turned)

    def plus(self, other: "Inertia") -> "Inertia":
        """Return the inertia of both together."""
        mass = self.mass + other.mass
        if mass == 0.0:
            return Inertia(0.0, self.centre, self.about_centre + other.about_centre)
        centre = (self.mass * self.centre + other.mass * other.centre) / mass
        whole = np.zeros((3, 3))
        for part in (self, other):
            d = part.centre - centre
            whole += part.about_centre + part.mass * (d @ d * np.eye(3) - np.outer(d, d))
        return Inertia(mass, centre, whole)


@dataclass(frozen=True)
class Link:
    """A link."""

    name: str
    line: int
    inertia: Inertia
    shapes: tuple[Shape, ...]


@dataclass(frozen=True)
class Mimic:
    """A joint follows another one: q = multiplier q_other + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class UrdfJoint:
    """A joint between two links; its frame is that of the child at q = 0."""

    name: str
    line: int
    kind: str
    parent: str
    child: str
    pose: Pose  # in the parent
    axis: Array  # (3,) unit vector in the frame of the joint
    lower: float | None
    upper: float | None
    effort: float
    damping: float
    friction: float
    mimic: Mimic | None


@dataclass(frozen=True)
class Robot:
    """Links and joints of a file, parents before children."""

    file: Path
    name: str
    root: str
    links: dict[str, Link]
    joints: dict[str, UrdfJoint]
    reductions: dict[str, float]  # of joints with a transmission, which may not be there
    notes: list[str]  # what is left out, missing or taken by default


def read_urdf(file: Path) -> Robot:
    """Read and check a URDF file.

    Raises
    ------
    InputError
        One line per mistake: file and line, element, value, expectation.
    """
    root = _tree(file)
    if root.tag != "robot":
        hint = "; an SDF file is another format" if root.tag == "sdf" else ""
        raise InputError(f"{file}:{root.line}: <{root.tag}>: expected <robot>, a URDF file{hint}")
    return _Reader(file, root).robot()


def _tree(file: Path) -> Element:
    """Return the root of an XML file without entities of its own."""
    data = file.read_bytes()
    if len(data) > MOST_BYTES:
        raise InputError(f"{file}: {len(data)} bytes: expected at most {MOST_BYTES}")
    parser = expat.ParserCreate()
    stack = [Element("", {}, 0)]

    def refused(message: str) -> InputError:
        return InputError(f"{file}:{parser.CurrentLineNumber}: {message}")

    def begin(tag: str, attributes: dict[str, str]) -> None:
        if len(stack) > 100:
            raise refused("elements too deep for a URDF")
        if tag.startswith("xacro:"):
            raise refused(f"<{tag}>: a xacro file; expected the URDF that `xacro FILE` makes of it")
        stack[-1].children.append(Element(tag, attributes, parser.CurrentLineNumber))
        stack.append(stack[-1].children[-1])

    def no_entities(*_: object) -> None:
        raise refused("<!ENTITY>: expected a file without entities")

    parser.StartElementHandler = begin
    parser.EndElementHandler = lambda _: stack.pop()

    def more(text: str) -> None:
        stack[-1].text += text

    parser.EntityDeclHandler = no_entities
    parser.CharacterDataHandler = more
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        text = expat.ErrorString(error.code)
        raise InputError(f"{file}:{error.lineno}: no XML: {text}") from None
    return stack[0].children[0]


class _Reader:
    """Reads the elements of one file and collects what is wrong."""

    def __init__(self, file: Path, root: Element) -> None:
        self._file, self._root = file, root
        self._found: list[str] = []
        self._notes: list[str] = []

    def robot(self) -> Robot:
        links = self._named("link", self._link)
        joints = self._named("joint", self._joint)
        for joint in joints.values():
            for end in (joint.parent, joint.child):
                if end and end not in links:
                    self._wrong(joint, f'link "{end}": no such link{nearest(end, links)}')
            if joint.mimic is not None:
                self._check_mimic(joint, joint.mimic, joints)
        refuse(self._found)
        root, ordered = self._ordered(links, joints)
        name = self._root.attributes.get("name") or self._file.stem
        return Robot(self._file, name, root, links, ordered, self._reductions(), self._notes)

    def _named(self, tag: str, read: Callable[[str, Element], Thing]) -> dict[str, Thing]:
        named: dict[str, Thing] = {}
        for element in self._root.all(tag):
            name = element.attributes.get("name", "")
            if not name or printable(name) != name:
                self._of(element, ": expected a name")
            elif name in named:
                self._of(element, f': a second {tag} "{name}"')
            elif "${" in name or "$(" in name:
                self._of(
                    element, ": a name of xacro; expected the URDF that `xacro FILE` makes of it"
                )
            else:
                self._spelled(f"{tag} {name}", element)
                named[name] = read(name, element)
        if tag == "link" and not named:
            self._of(self._root, ": no link; expected one or more")
        return named

    def _spelled(self, where: str, element: Element) -> None:
        """Refuse second elements where one is read, and what looks like one that is missing."""
        once, attributes = (words.split() for words in KNOWN[element.tag])
        tags = [child.tag for child in element.children]
        for k, child in enumerate(element.children):
            if child.tag in tags[:k] and child.tag in once:
                self._say(child.line, f"{where}: a second <{child.tag}>; expected one")
            elif child.tag in once and child.tag in KNOWN:
                self._spelled(where, child)
            elif meant := _meant(child.tag, once, tags):
                text = (
                    f"{where}: <{printable(child.tag)}>: no such element; did you mean {meant!r}?"
                )
                self._say(child.line, text)
        for key in element.attributes:
            if meant := _meant(key, attributes, element.attributes):
                text = (
                    f"{where}, <{element.tag} {printable(key)}>: no such attribute; did you mean "
                )
                self._say(element.line, f"{text}{meant!r}?")

    def _say(self, line: int, text: str) -> None:
        self._found.append(f"{self._file}:{line}: {text}")

    def _note(self, joint: Element, text: str) -> None:
        name = joint.attributes["name"]
        self._notes.append(f"{self._file.name}:{joint.line}: <joint {name}>: {text}")

    def _of(self, element: Element, text: str) -> None:
        name = element.attributes.get("name")
        self._say(element.line, f"<{element.tag}{f' {name}' if name else ''}>{text}")

    def _wrong(self, joint: UrdfJoint, text: str) -> None:
        self._say(joint.line, f"<joint {joint.name}>: {text}")

    def _numbers(
        self,
        where: str,
        element: Element,
        key: str,
        count: int,
        default: "tuple[float, ...] | None",
    ) -> Array:
        """Return the numbers of an attribute; None: it is required."""
        text = element.attributes.get(key)
        if text is None and default is not None:
            return np.array(default)
        words = (text or "").split()
        try:
            # 1_0 and digits of other scripts are numbers in Python only
            values = [float(w if w.isascii() and "_" not in w else "") for w in words]
        except ValueError:
            values = []
        if len(values) != count or not all(map(math.isfinite, values)):
            shown = "missing" if text is None else f'"{printable(text)}"'
            what = "a number" if count == 1 else f"{count} numbers with spaces between"
            self._say(element.line, f"{where}, <{element.tag} {key}>: {shown}; expected {what}")
            return np.array(default if default is not None else (1.0,) * count)
        return np.array(values)

    def _number(self, where: str, element: "Element | None", key: str, default: float) -> float:
        if element is None:
            return default
        return float(self._numbers(where, element, key, 1, (default,))[0])

    def _pose(self, where: str, element: Element) -> Pose:
        origin = element.one("origin")
        if origin is None:
            return HERE
        p = self._numbers(where, origin, "xyz", 3, (0.0,) * 3)
        roll, pitch, yaw = angles = self._numbers(where, origin, "rpy", 3, (0.0,) * 3)
        if np.abs(angles).max() > TURNS:
            text = " ".join(f"{angle:g}" for angle in angles)
            self._say(
                origin.line, f"{where}, <origin rpy>: {text}; expected rad, found some like deg"
            )
        if np.abs(p).max() > FAR:
            text = " ".join(f"{x:g}" for x in p)
            self._say(origin.line, f"{where}, <origin xyz>: {text}; expected m, within {FAR:g}")
        x, y, z = np.eye(3)
        return Pose(p, about(z, yaw) @ about(y, pitch) @ about(x, roll))

    def _link(self, name: str, element: Element) -> Link:
        where = f"link {name}"
        shapes = tuple(s for e in element.all("visual") for s in self._shape(where, e))
        return Link(name, element.line, self._inertia(where, element), shapes)

    def _inertia(self, where: str, element: Element) -> Inertia:
        inertial = element.one("inertial")
        if inertial is None:
            return Inertia(0.0, np.zeros(3), np.zeros((3, 3)))
        pose = self._pose(where, inertial)
        of_mass, moments = inertial.one("mass"), inertial.one("inertia")
        mass, values = 0.0, np.zeros(6)
        if of_mass is None:
            self._of(inertial, f" of {where}: no <mass>; expected one [kg]")
        else:
            mass = float(self._numbers(where, of_mass, "value", 1, None)[0])
            if mass < 0.0:
                text = f"{where}, <mass value>: {mass:g}; expected 0 or above [kg]"
                self._say(of_mass.line, text)
        if moments is not None:
            for k, key in enumerate(("ixx", "iyy", "izz", "ixy", "ixz", "iyz")):
                default = None if k < 3 else (0.0,)
                values[k] = self._numbers(where, moments, key, 1, default)[0]
        xx, yy, zz, xy, xz, yz = values
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return Inertia(mass, pose.p, pose.A @ matrix @ pose.A.T)

    def _shape(self, where: str, visual: Element) -> Iterator[Shape]:
        geometry = visual.one("geometry")
        if geometry is None:
            return
        pose = self._pose(where, visual)
        for child in geometry.children:
            if child.tag not in SIZES:
                continue
            default = (1.0,) * 3 if child.tag == MESH else None
            sizes = [
                float(size)
                for key, count in SIZES[child.tag].items()
                for size in self._numbers(where, child, key, count, default)
            ]
            if child.tag != MESH and min(sizes) < 0.0:
                text = f"{where}, <{child.tag}>: {min(sizes):g}; expected sizes of 0 or above [m]"
                self._say(child.line, text)
            if child.tag == MESH and 0.0 in sizes:
                self._say(child.line, f"{where}, <mesh scale>: 0; expected factors other than 0")
            file = child.attributes.get("filename", "")
            if child.tag == MESH and not file:
                self._of(child, f" of {where}: expected a filename")
            yield Shape(pose, child.tag, tuple(sizes), file, child.line)

    def _joint(self, name: str, element: Element) -> UrdfJoint:
        where, kind = f"joint {name}", element.attributes.get("type", "")
        if kind not in tuple(Type):
            types = [str(each) for each in Type]
            expectation = f"expected one of {', '.join(types)}{did_you_mean(kind, types)}"
            self._of(element, f': type = "{printable(kind)}"; {expectation}')
        ends = []
        for tag in ("parent", "child"):
            end = element.one(tag)
            ends.append(end.attributes.get("link", "") if end is not None else "")
            if not ends[-1]:
                self._of(element, f': expected <{tag} link="...">')
        if ends[0] and ends[0] == ends[1]:
            self._of(element, f': expected two links, found "{ends[0]}" twice')
        given, axis = element.one("axis"), np.array([1.0, 0.0, 0.0])
        if given is not None:
            axis = self._numbers(where, given, "xyz", 3, (1.0, 0.0, 0.0))
        if (given is None or "xyz" not in given.attributes) and kind not in WITHOUT_AXIS:
            self._note(element, "no <axis xyz>: it turns about or moves along x, URDF's default")
        length = math.hypot(*axis)
        if length == 0.0 and kind not in WITHOUT_AXIS:
            line = given.line if given is not None else element.line
            self._say(line, f"{where}, <axis xyz>: expected a vector of non-zero length")
        limit, dynamics = element.one("limit"), element.one("dynamics")
        lower = upper = None
        if limit is not None and kind in (Type.REVOLUTE, Type.PRISMATIC):
            lower = self._number(where, limit, "lower", 0.0)
            upper = self._number(where, limit, "upper", 0.0)
            if lower > upper:
                text = f"lower = {lower:g}; expected at most upper = {upper:g}"
                self._say(limit.line, f"{where}, <limit>: {text}")
            if not self._number(where, limit, "effort", 0.0) > 0.0:
                self._note(element, "no stops: its <limit> has no effort above 0")
            if "velocity" not in limit.attributes:
                self._note(element, "its <limit> has no velocity, which URDF demands; none is used")
        elif kind in (Type.REVOLUTE, Type.PRISMATIC):
            more = ", or type continuous" if kind == Type.REVOLUTE else ""
            text = f"no stops: it has no <limit>; expected one for type {kind}{more}"
            self._note(element, text)
        mimic = element.one("mimic")
        values = [self._number(where, dynamics, key, 0.0) for key in Dynamics]
        if min(values) < 0.0:
            self._of(element, ", <dynamics>: expected values of 0 or above")
        follows = (
            None
            if mimic is None
            else Mimic(
                mimic.attributes.get("joint", ""),
                self._number(where, mimic, "multiplier", 1.0),
                self._number(where, mimic, "offset", 0.0),
            )
        )
        return UrdfJoint(
            name=name,
            line=element.line,
            kind=kind,
            parent=ends[0],
            child=ends[1],
            pose=self._pose(where, element),
            axis=axis / (length or 1.0),
            lower=lower,
            upper=upper,
            effort=max(self._number(where, limit, "effort", 0.0), 0.0),
            damping=values[0],
            friction=values[1],
            mimic=follows,
        )

    def _check_mimic(self, joint: UrdfJoint, mimic: Mimic, joints: dict[str, UrdfJoint]) -> None:
        where = f'<mimic joint="{mimic.joint}">'
        one_way = (Type.REVOLUTE, Type.CONTINUOUS, Type.PRISMATIC)
        if mimic.joint == joint.name:
            self._wrong(joint, f"{where}: expected another joint")
        elif mimic.joint not in joints:
            self._wrong(joint, f"{where}: no such joint{nearest(mimic.joint, joints)}")
        elif {joint.kind, joints[mimic.joint].kind} - {*one_way, Type.FIXED}:
            self._wrong(joint, f"{where}: expected {', '.join(one_way)} joints on both sides")
        elif not 1.0 / FAR <= abs(mimic.multiplier) <= FAR:
            text = f"{where}: multiplier = {mimic.multiplier:g}"
            self._wrong(joint, f"{text}; expected another number, or type fixed")
        elif abs(mimic.offset) > (FAR if joint.kind == Type.PRISMATIC else TURNS):
            what = "m" if joint.kind == Type.PRISMATIC else "rad, found some like deg"
            self._wrong(joint, f"{where}: offset = {mimic.offset:g}; expected {what}")
        else:
            seen = {joint.name}
            while (of := joints[mimic.joint].mimic) is not None and of.joint in joints:
                if mimic.joint in seen:
                    self._wrong(joint, f"{where}: joints that mimic each other in a circle")
                    break
                seen.add(mimic.joint)
                mimic = of

    def _ordered(
        self, links: dict[str, Link], joints: dict[str, UrdfJoint]
    ) -> tuple[str, dict[str, UrdfJoint]]:
        """Return the root link and the joints, parents before children."""
        above: dict[str, UrdfJoint] = {}
        for joint in joints.values():
            if joint.child in above:
                other = above[joint.child].name
                self._wrong(
                    joint,
                    f'link "{joint.child}" is the child of joint "{other}" too, which closes a '
                    "loop; expected a tree: each link is the child of one joint at most",
                )
            above[joint.child] = joint
        refuse(self._found)
        roots = [name for name in links if name not in above]
        if len(roots) != 1:
            listed = ", ".join(roots) or "none: the joints form a circle"
            line = links[roots[1]].line if roots else next(iter(joints.values())).line
            raise InputError(
                f"{self._file}:{line}: links without a parent: {listed}; expected one root"
            )
        below: dict[str, list[UrdfJoint]] = {}
        for joint in joints.values():
            below.setdefault(joint.parent, []).append(joint)
        ordered, waiting = dict[str, UrdfJoint](), [roots[0]]
        while waiting:
            for joint in below.get(waiting.pop(), []):
                ordered[joint.name] = joint
                waiting.append(joint.child)
        for joint in joints.values():
            if joint.name not in ordered:
                self._wrong(joint, "a circle of joints; expected a tree from the root link")
        refuse(self._found)
        return roots[0], ordered

    def _reductions(self) -> dict[str, float]:
        ratios: dict[str, float] = {}
        for transmission in self._root.all("transmission"):
            holders = [transmission, *transmission.all("joint"), *transmission.all("actuator")]
            names = [j.attributes.get("name", "") for j in transmission.all("joint")]
            own = [e for holder in holders for e in holder.all("mechanicalReduction")]
            if not own:
                continue
            text = (own[0].text or own[0].attributes.get("value", "")).strip()
            try:
                value = float(text)
            except ValueError:
                value = 0.0
            if value == 0.0 or not math.isfinite(value):
                where = f"{self._file.name}:{own[0].line}: transmission of {', '.join(names)}"
                self._notes.append(
                    f"{where}: left out: "
                    f'<mechanicalReduction> "{printable(text)}"; expected a number other than 0'
                )
                continue
            ratios |= dict.fromkeys(names, value)
        return ratios


def _meant(word: str, known: list[str], there: Collection[str]) -> str:
    """Return what is meant by a word that is not known, of what is not there; or nothing."""
    missing = [each for each in known if each not in there]
    return "" if word in known else next(iter(get_close_matches(word, missing, 1, ALIKE)), "")


def about(axis: Array, angle: float) -> Array:
    """Return the rotation (3, 3) by an angle [rad] about a unit vector (3,)."""
    return vector_to_matrix(angle * np.asarray(axis))
