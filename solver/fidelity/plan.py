"""A plan: which model a run takes. It is written as TOML, may be edited, and is read again."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..errors import InputError, nearest
from ..package.common.temporary import write_text

LEAST_RTOL, MOST_RTOL = 1e-9, 1e-3  # small deflections need the first: errors are of the size


@dataclass(frozen=True)
class BodyPlan:
    """What the model has of one flexible body.

    Attributes
    ----------
    vibrations : labels of the vibrations, as in the package
    static : number of static shapes of the loads that act on it in the run
    ringing : the static shapes are undamped; otherwise they have a damping ratio that suppresses
        their vibrations
    mesh : "model" or "check": package that its modes come from
    """

    vibrations: tuple[str, ...] = ()
    static: int = 0
    ringing: bool = False
    mesh: str = "model"

    @property
    def rigid(self) -> bool:
        """True if the model has none of its deformation."""
        return not self.vibrations and not self.static


@dataclass(frozen=True)
class Plan:
    """The model of a run.

    Attributes
    ----------
    bodies : of the flexible bodies, by name
    stiffening : geometric stiffening
    rtol : tolerance of the integrator
    inputs_sha256 : of what it was made for; "" if it does not say
    """

    bodies: dict[str, BodyPlan]
    stiffening: bool
    rtol: float
    inputs_sha256: str = field(default="", compare=False)

    def with_body(self, name: str, **changes: Any) -> "Plan":
        """Return the plan with another model of one body."""
        return replace(self, bodies={**self.bodies, name: replace(self.bodies[name], **changes)})

    def table(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "rtol": self.rtol,
            "geometric_stiffening": self.stiffening,
            "bodies": {
                name: {
                    "vibrations": list(body.vibrations),
                    "static_shapes": body.static,
                    "ringing": body.ringing,
                    "mesh": body.mesh,
                }
                for name, body in self.bodies.items()
            },
        }


def kind_of(label: str) -> str:
    """Return the kind of a vibration from its label, "bending-xy" of "bending-xy 3"."""
    return label.rpartition(" ")[0]


def outline(plan: Plan) -> str:
    """Return a plan in a few words: modes of each body, stiffening, tolerance."""
    bodies = []
    for name, body in plan.bodies.items():
        ring = " undamped" if body.ringing and body.static else ""
        modes = f"{len(body.vibrations)}+{body.static}{ring}"
        bodies.append(f"{name} {'rigid' if body.rigid else modes}")
    stiffening = ", stiffening" if plan.stiffening else ""
    return f"{', '.join(bodies)}{stiffening}, rtol {plan.rtol:.1g}"


def write_plan(file: Path, plan: Plan, remarks: list[str]) -> None:
    """Write a plan as TOML with remarks, under a temporary name that is then renamed."""
    lines = [*(f"# {remark}" for remark in remarks), "format = 1"]
    lines += [f'inputs_sha256 = "{plan.inputs_sha256}"', f"rtol = {plan.rtol:.6g}"]
    lines += [f"geometric_stiffening = {str(plan.stiffening).lower()}"]
    for name, body in plan.bodies.items():
        names = ", ".join(f'"{label}"' for label in body.vibrations)
        lines += [
            "",
            f"[bodies.{name}]",
            f"vibrations = [{names}]",
            f"static_shapes = {body.static}",
            f"ringing = {str(body.ringing).lower()}",
            f'mesh = "{body.mesh}"',
        ]
    write_text(file, "\n".join(lines) + "\n")


BODY_KEYS: dict[str, type] = {
    "vibrations": list,
    "static_shapes": int,
    "ringing": bool,
    "mesh": str,
}
KEYS: dict[str, type] = {
    "format": int,
    "inputs_sha256": str,
    "rtol": float,
    "geometric_stiffening": bool,
    "bodies": dict,
}


def read_plan(file: Path, known: Mapping[str, Mapping[str, tuple[str, ...]]]) -> Plan:
    """Read a plan; `known` has the labels of the vibrations of each flexible body, by mesh.

    Raises
    ------
    InputError
        File, key, value and expectation of what is wrong.
    """
    try:
        table = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: not a plan ({error}); expected TOML") from error
    _keys(f"{file}: ", table, KEYS)
    if not 0.0 < table["rtol"] <= 0.1:
        raise InputError(f"{file}: rtol = {table['rtol']}: expected above 0, at most 0.1")
    bodies = {}
    for name, entry in table["bodies"].items():
        where = f"{file}: bodies.{name}"
        if name not in known:
            raise InputError(f"{where}: no such flexible body{nearest(name, known)}")
        if not isinstance(entry, dict):
            raise InputError(f"{where} = {entry!r}: expected a table")
        _keys(f"{where}.", entry, BODY_KEYS)
        if not 0 <= entry["static_shapes"] <= 20:
            value = entry["static_shapes"]
            raise InputError(f"{where}.static_shapes = {value}: expected 0 to 20")
        if entry["mesh"] not in ("model", "check"):
            raise InputError(f'{where}.mesh = "{entry["mesh"]}": expected "model" or "check"')
        for label in entry["vibrations"]:
            if label not in known[name][entry["mesh"]]:
                hint = nearest(str(label), known[name][entry["mesh"]])
                raise InputError(f'{where}.vibrations = "{label}": no such vibration{hint}')
        bodies[name] = BodyPlan(
            tuple(entry["vibrations"]), entry["static_shapes"], entry["ringing"], entry["mesh"]
        )
    for name in known:
        if name not in bodies:
            raise InputError(f"{file}: bodies.{name}: missing; expected a table for each body")
    return Plan(bodies, table["geometric_stiffening"], table["rtol"], table["inputs_sha256"])


def _keys(where: str, table: Mapping[str, Any], keys: Mapping[str, type]) -> None:
    for key in table:
        if key not in keys:
            raise InputError(f"{where}{key}: unknown key{nearest(key, keys)}")
    for key, kind in keys.items():
        if key not in table:
            raise InputError(f"{where}{key}: missing")
        value = table[key]
        fits = isinstance(value, int | float) if kind is float else isinstance(value, kind)
        if not fits or (kind is not bool and isinstance(value, bool)):
            raise InputError(f"{where}{key} = {value!r}: expected a value of type {kind.__name__}")
