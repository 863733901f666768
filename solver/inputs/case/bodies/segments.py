"""Beams in segments: a body of the case becomes several bodies, joined to each other.

Each segment is a body of its own, with the mean position of the segment as its frame, the static
shapes of its ends and one of axial load. In a chord frame, bent segments lose inertia of torsion.
Equal segments have equal specifications, so they share one package. Places of the body ("arm.tip"),
its loads, joints, masses and signals become those of its segments.
"""

from typing import Any

import numpy as np

from ....math.arrays import Array
from ....math.laws import lengths_along
from ....math.rotations import matrix_to_vector, vector_to_matrix
from ..tables.beam_keys import BeamBody
from ..tables.schema import Mechanism, resolved
from .beams import division, fractions, is_plain, line_of, rounded, with_sections

NEAR = 1e-9  # fractions closer than this are one place

# All six static shapes of the ends; a chord carries the other loads.
SHAPES: list[dict[str, object]] = [
    {"kind": "attachment", "at": "start", "directions": ["ry", "rz"]},
    {"kind": "attachment", "at": "end", "directions": ["x", "rx", "ry", "rz"]},
    {"kind": "static-axial"},
]


def in_segments(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with all beams of several segments divided.

    The mechanism has passed `cross_check`. Without such beams it is returned as it is.
    """
    divided = {
        name: _Divided(name, body)
        for name, body in mechanism.bodies.items()
        if isinstance(body, BeamBody) and body.segments > 1
    }
    if not divided:
        return mechanism
    table = mechanism.model_dump()
    bodies: dict[str, object] = {}
    joints: dict[str, object] = {}
    for name, body in table["bodies"].items():
        if name not in divided:
            bodies[name] = body
            continue
        bodies |= divided[name].bodies()
        joints |= divided[name].joints()
    new = {f"{d.name}.{place}": to for d in divided.values() for place, to in d.places.items()}
    blades = {
        d.name: {"places": d.places, "rotation_deg": d.body.rotation_deg} for d in divided.values()
    }
    signals = {name: _signal(signal, divided, new) for name, signal in table["signals"].items()}
    return resolved(
        table
        | {
            "bodies": bodies,
            "joints": joints | _renamed(table["joints"], new),
            "forces": _renamed(table["forces"], new),
            "masses": _renamed(table["masses"], new),
            "signals": signals,
            "rotor": table["rotor"] and {**table["rotor"], "divided": blades},
        },
        "mechanism in segments",
    )


def check_names(mechanism: Mechanism) -> list[str]:
    """Return bodies and joints with the name of the ground, of a segment or of its joint."""
    errors = []
    if "ground" in mechanism.bodies:
        errors.append('bodies.ground: expected another name, places "ground.POINT" are fixed')
    for name, body in mechanism.bodies.items():
        if not (isinstance(body, BeamBody) and body.segments > 1):
            continue
        own = [segment_name(name, k) for k in range(body.segments)]
        between = [joint_name(name, k) for k in range(body.segments - 1)]
        errors += [
            f"{table}.{taken}: expected another name, it is that of a part of body {name}"
            for table, names, known in (
                ("bodies", own, mechanism.bodies),
                ("joints", between, mechanism.joints),
            )
            for taken in names
            if taken in known
        ]
        if body.reference.kind == "mean-axis":
            errors.append(
                f'bodies.{name}.reference.kind = "mean-axis": expected clamped or chord with '
                "`segments`; deflections are relative to it"
            )
    return errors


def segment_name(body: str, k: int) -> str:
    """Return the name of segment k (from 0) of a body."""
    return f"{body}-{k + 1}"


def joint_name(body: str, k: int) -> str:
    """Return the name of the joint between segments k and k + 1."""
    return f"{body}-{k + 1}-{k + 2}"


class _Divided:
    """A beam in segments.

    Attributes
    ----------
    places : interface of the body -> "SEGMENT.INTERFACE"
    """

    def __init__(self, name: str, body: BeamBody) -> None:
        self.name, self.body, self.count = name, body, body.segments
        self.line = line_of(body)
        self.at = fractions(body)
        self.places: dict[str, str] = {}
        self._inner: list[dict[str, float]] = [{} for _ in range(self.count)]
        for interface, fraction in self.at.items():
            number = round(fraction * self.count)
            if abs(fraction * self.count - number) < NEAR * self.count:
                end = "start" if number == 0 else "end"
                self.places[interface] = f"{segment_name(name, max(number - 1, 0))}.{end}"
            else:
                k = int(fraction * self.count)
                self._inner[k][interface] = fraction * self.count - k
                self.places[interface] = f"{segment_name(name, k)}.{_inner(interface)}"

    def bodies(self) -> dict[str, object]:
        """Return the tables of the segments."""
        table, start = self.body.model_dump(), np.array(self.body.position)
        A_GB = vector_to_matrix(np.radians(self.body.rotation_deg))
        segments: dict[str, object] = {}
        for k in range(self.count):
            shape, origin, A_BS = self._shape(k)
            interfaces: dict[str, object] = {"start": {"at": "start"}, "end": {"at": "end"}}
            interfaces |= {_inner(n): {"at": f} for n, f in self._inner[k].items()}
            turn = np.degrees(matrix_to_vector(A_GB @ A_BS))
            own = {
                **table,
                **shape,
                "stations": self._stations(k),
                "segments": 1,
                "part_of": self.name,
                "reference": {"kind": "mean-axis", "at": ["start", "end"]},
                "modes": [*SHAPES, *self._modes(k)],
                "interfaces": interfaces,
                "position": (start + A_GB @ origin).tolist(),
                "rotation_deg": turn.tolist(),
                **_velocities(self.body, origin, A_GB, A_BS, first=k == 0),
            }
            segments[segment_name(self.name, k)] = own
        return segments

    def joints(self) -> dict[str, object]:
        """Return the joints between neighbouring segments."""
        pairs = [
            [f"{segment_name(self.name, k)}.end", f"{segment_name(self.name, k + 1)}.start"]
            for k in range(self.count - 1)
        ]
        return {
            joint_name(self.name, k): {"kind": "fixed", "between": pair}
            for k, pair in enumerate(pairs)
        }

    def segment_at(self, x: float) -> tuple[str, float]:
        """Return the segment at x along the body [m], and the place along it."""
        part = self.line.length / self.count
        k = min(int(x / part * (1.0 + NEAR)), self.count - 1)
        share = min(max(x / part - k, 0.0), 1.0)
        shape, _, _ = self._shape(k)
        own = shape["length"] or lengths_along(np.array(shape["line"]["nodes"]))[-1]
        return segment_name(self.name, k), float(share * own)

    def frame(self, at: str, seen_from: str | None) -> dict[str, object]:
        """Return the frame in which deflections of the interface `at` are measured."""
        carriers = [seen_from] if seen_from else self.body.reference.places
        named = [carrier.rpartition(".")[2] for carrier in carriers]
        places = self.line.place(np.array([self.at[n] for n in [*named, at]]))
        return {
            "places": [self.places[n] for n in named],
            "chord": (places[1] - places[0]).tolist() if len(named) == 2 else None,
            "rest": (places[-1] - places[0]).tolist(),
            "rotation_deg": list(self.body.rotation_deg),
        }

    def _shape(self, k: int) -> tuple[dict[str, Any], Array, Array]:
        """Return length and line of a segment, its origin and its axes in the body frame."""
        body, n = self.body, self.count
        elements = max(-(-body.elements // n), 1 + len(self._inner[k]))
        if is_plain(body):
            assert body.length is not None
            part = body.length / n
            return {"length": part, "elements": elements}, np.array([k * part, 0.0, 0.0]), np.eye(3)
        own = body.model_copy(update={"elements": n * elements})
        cuts = np.arange(n + 1) / n
        nodes = np.unique(np.concatenate([division(own), cuts]))
        nodes = nodes[np.concatenate([[True], np.diff(nodes) > NEAR])]
        inside = (nodes > cuts[k] - NEAR) & (nodes < cuts[k + 1] + NEAR)
        nodes = nodes[inside]
        points = self.line.place(nodes)
        axes = self.line.x2(0.5 * (nodes[:-1] + nodes[1:]))
        e1 = points[-1] - points[0]
        e1 = e1 / np.linalg.norm(e1)
        e2 = axes[len(axes) // 2] - (axes[len(axes) // 2] @ e1) * e1
        e2 = e2 / np.linalg.norm(e2)
        A_BS = np.column_stack([e1, e2, np.cross(e1, e2)])
        local = np.array(rounded((points - points[0]) @ A_BS, self.line.length))
        local[[0, -1], 1:] = 0.0
        line = {"nodes": local.tolist(), "x2_axes": rounded(axes @ A_BS, 1.0)}
        shape = {"length": None, "line": line, "twist_deg": [], "x2_axis": [0.0, 1.0, 0.0]}
        shape["table"] = None
        return {**shape, "elements": len(local) - 1}, points[0], A_BS

    def _stations(self, k: int) -> list[dict[str, object]]:
        """Return the stations of the body as fractions of a segment."""
        if not self.body.stations:
            return []
        return [
            {**station.model_dump(), "at": station.at * self.count - k}
            for station in with_sections(self.body)
        ]

    def _modes(self, k: int) -> list[object]:
        """Return the modes of the body that are those of segment k."""
        modes: list[object] = []
        for mode in self.body.modes:
            if mode.kind == "attachment":
                segment, _, interface = self.places[mode.at].partition(".")
                if segment == segment_name(self.name, k) and interface not in ("start", "end"):
                    modes.append({**mode.model_dump(), "at": interface})
            elif mode.kind != "static-axial":
                modes.append(mode.model_dump())
        return modes


def _inner(interface: str) -> str:
    """Return the name of an interface inside a segment, which is none of its ends."""
    return f"at-{interface}"


def _velocities(
    body: BeamBody, origin: Array, A_GB: Array, A_BS: Array, *, first: bool
) -> dict[str, object]:
    """Return the given velocities of a segment that moves with the undeformed body."""
    velocity, spin = body.velocity, body.angular_velocity
    if velocity is not None and not first:
        velocity = None if spin is None else (velocity + A_GB @ np.cross(spin, origin)).tolist()
    if spin is not None:
        spin = (A_BS.T @ np.array(spin)).tolist()
    return {"velocity": velocity, "angular_velocity": spin}


def _signal(
    signal: dict[str, Any], divided: dict[str, _Divided], new: dict[str, str]
) -> dict[str, Any]:
    owner, _, interface = str(signal.get("at") or "").partition(".")
    if signal["kind"] in ("deflection", "rotation") and owner in divided:
        frame = divided[owner].frame(interface, signal.get("seen_from"))
        signal = {**signal, "seen_from": None, "frame": frame}
    owner = str(signal.get("body"))
    if owner in divided and signal["x"] is None:
        segments = list(divided[owner].bodies())
        signal = {**signal, "body": segments[0], "segments": segments}
    elif owner in divided:
        segment, x = divided[owner].segment_at(signal["x"])
        signal = {**signal, "body": segment, "x": x}
        if signal.get("method") == "auto" and is_plain(divided[owner].body):
            signal["method"] = "equilibrium"
    return dict(_renamed(signal, new))


def _renamed(value: Any, new: dict[str, str]) -> Any:
    """Return plain data with places of bodies replaced by those of their segments."""
    if isinstance(value, dict):
        return {key: _renamed(item, new) for key, item in value.items()}
    if isinstance(value, list):
        return [_renamed(item, new) for item in value]
    return new.get(value, value) if isinstance(value, str) else value
