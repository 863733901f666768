"""Choice of a plan from the indicators, and the file of a plan (TOML), which may be edited.

The cheapest additions come first, until the losses are small.
"""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...errors import InputError, nearest, printable, refuse, unknown
from ...inputs.common.input_table import Table, entry, validated
from ...inputs.common.text_file import read_toml
from ...math.arrays import Array
from ...package.common.files import write_text
from ...package.common.plain_data import toml_text
from ...run.inputs import plan_sha256, text_sha256
from ..tolerances import (
    DAMPED_ABOVE,
    LEAST_RTOL,
    MOST_RTOL,
    OMITTED_SHARE,
    STIFFENING_SHARE,
    STIFFENING_SPIN,
)
from .indicators.response import Indicators
from .plan import BodyPlan, Plan, Rich
from .plan import rows as rows_of

SHAPE_SHARE = 0.1  # of the accuracy, for static shapes that are left out
COST = {"vibration": 1.0, "static": 1.5, "ringing": 6.0}  # of an addition, relative
MOTIONS = ("position", "velocity", "angular_velocity", "orientation", "joint")
MOTION_RTOL, OTHER_RTOL = 3.0, 30.0  # accuracy over tolerance, by the kind of signal


def chosen(
    indicators: Indicators,
    rich: Mapping[str, Rich],
    accuracy: float,
    kinds: Mapping[str, str],
    least: Mapping[str, BodyPlan],
) -> tuple[Plan, Array]:
    """Return a plan whose losses are below OMITTED_SHARE of the accuracy, and its losses (o,).

    Parameters
    ----------
    kinds : of the signals
    least : what each body has at least
    """
    spin = max(indicators.spin.values(), default=0.0)
    stiffening = bool(
        (indicators.stiffening > STIFFENING_SHARE * accuracy).any() or spin > STIFFENING_SPIN
    )
    by = max(accuracy_over_rtol(indicators, kinds))
    rtol = min(max(accuracy / by, LEAST_RTOL), MOST_RTOL)
    plan = Plan(dict(least), stiffening, rtol)
    omitted = _omitted(indicators, plan)
    loss = indicators.loss(omitted.sum(axis=2))
    while loss.max(initial=0.0) > OMITTED_SHARE * accuracy:
        additions = list(_additions(indicators, plan, omitted))
        if not additions:
            break
        lost = omitted.sum(axis=2) - np.array([gained for _, _, gained in additions])
        after = indicators.loss(lost)  # (additions, o)
        gain = np.maximum(loss, OMITTED_SHARE * accuracy).sum()
        gain = gain - np.maximum(after, OMITTED_SHARE * accuracy).sum(axis=1)
        best = int(np.argmax(gain / np.array([COST[kind] for kind, _, _ in additions])))
        plan, loss = additions[best][1], after[best]
        omitted = _omitted(indicators, plan)
    tight = any(kinds[name] not in MOTIONS for name in indicators.names)
    for name, body in plan.bodies.items():
        if body.static:
            count = _shapes(indicators, plan, name, rich[name], SHAPE_SHARE * accuracy)
            ringing = body.ringing or (tight and accuracy < DAMPED_ABOVE)
            plan = plan.with_body(name, static=max(count, least[name].static), ringing=ringing)
    return plan, loss


def accuracy_over_rtol(indicators: Indicators, kinds: Mapping[str, str]) -> tuple[float, float]:
    """Return the accuracy over the tolerance of a plan: by the kinds of the signals, and by the
    size of the deflections that they follow from."""
    by = MOTION_RTOL if all(kinds[n] in MOTIONS for n in indicators.names) else OTHER_RTOL
    return by, MOTION_RTOL * float(indicators.amplified.max(initial=0.0))


def _additions(
    indicators: Indicators, plan: Plan, omitted: Array
) -> Iterator[tuple[str, Plan, Array]]:
    """Return kind, plan and regained contributions (o, k) of each addition to a plan."""
    left: dict[str, list[int]] = {name: [] for name in plan.bodies}
    for j, mode in enumerate(indicators.modes):
        kept = plan.bodies[mode.body].vibrations
        if mode.label not in kept:
            left[mode.body].append(j)
            if mode.vibration:
                more = plan.with_body(mode.body, vibrations=(*kept, mode.label))
                yield "vibration", more, omitted[:, :, j]
    for name, body in plan.bodies.items():
        if not body.static:
            regained = indicators.effects.static[:, :, left[name]].sum(axis=2)
            yield "static", plan.with_body(name, static=1), regained
        elif not body.ringing:
            regained = omitted[:, :, left[name]].sum(axis=2)
            yield "ringing", plan.with_body(name, ringing=True), regained


def _omitted(indicators: Indicators, plan: Plan) -> Array:
    """Return the contributions of the modes (o, k, m) that a plan leaves out."""
    parts = indicators.effects
    kept, static = np.zeros((2, len(indicators.modes)), dtype=bool)
    for j, mode in enumerate(indicators.modes):
        body = plan.bodies[mode.body]
        of_plan = mode.vibration and mode.label in body.vibrations
        kept[j], static[j] = of_plan or (body.static and body.ringing), body.static > 0
    return np.where(kept, 0.0, parts.response - np.where(static, parts.static, 0.0))


def _shapes(indicators: Indicators, plan: Plan, name: str, rich: Rich, allowed: float) -> int:
    """Return how many static shapes of a body keep the quasi-static response to `allowed`."""
    kept = rows_of(rich.package, plan.bodies[name].vibrations)
    shapes = rich.rest(kept, stiffening=plan.stiffening)
    worth = rich.energies(shapes)
    eta, K = rich.eta, rich.package.stiffness
    mine = [j for j, mode in enumerate(indicators.modes) if mode.body == name]
    labels = {label: i for i, label in enumerate(rich.package.mode_labels)}
    own = [labels[indicators.modes[j].label] for j in mine]
    usable = int(np.sum(worth > 1e-6 * max(float(worth.max(initial=0.0)), 1e-300)))
    unit = shapes[:, :usable] / worth[:usable]
    along = eta @ K @ unit  # (k, r) coordinates of the response in the shapes
    static = indicators.effects.static[:, :, mine]
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(eta[None, :, own] != 0.0, static / eta[None, :, own], 0.0)
    for count in range(1, usable + 1):
        left = along[:, count:] @ unit[own, count:].T  # (k, m)
        lost = np.einsum("okm,km->ok", slope, left)
        if float(indicators.loss(lost).max(initial=0.0)) <= allowed:
            return count
    return usable


FORMAT = 1
MOST_SHAPES = 20


class BodyTable(Table):
    """`[bodies.NAME]` of the file of a plan."""

    vibrations: list[str] = entry("labels of the vibrations, as in the package")
    static_shapes: int = entry("number of static shapes", ge=0, le=MOST_SHAPES)
    ringing: bool = entry("the static shapes are undamped")
    mesh: Literal["model", "check"] = entry("package that the modes come from")
    whole: bool = entry("all modes of the package that respond, as a check", default=False)


class PlanTable(Table):
    """The file of a plan."""

    format: int = entry("version of the format", ge=FORMAT, le=FORMAT)
    inputs_sha256: str = entry("digest of what the plan was made for")
    rtol: float = entry("tolerance of the integrator", ge=1e-15, le=0.1)  # as of the solver
    geometric_stiffening: bool = entry("geometric stiffening")
    bodies: dict[str, BodyTable] = entry("the flexible bodies")


Known = Mapping[str, Mapping[str, tuple[str, ...]]]


def write_plan(file: Path, plan: Plan, remarks: list[str]) -> None:
    """Write a plan as TOML with remarks, under a temporary name that is then renamed.

    Another plan of this name, which may have been edited, is kept as NAME.previous.toml.

    Parameters
    ----------
    file : of the plan, in a folder that is there
    remarks : comments at its top, a line each
    """
    table = plan.table()
    bodies = table.pop("bodies")
    head = {"format": FORMAT, "inputs_sha256": plan.inputs_sha256, **table}
    parts = ["".join(f"# {printable(remark)}\n" for remark in remarks) + toml_text(head)]
    parts += [f"[bodies.{name}]\n{toml_text(body)}" for name, body in bodies.items()]
    text = "\n".join(parts if bodies else [*parts, "[bodies]\n"])
    if file.is_file() and (there := plan_sha256(file)) and there != text_sha256(text):
        os.replace(file, file.with_suffix(".previous.toml"))
    write_text(file, text)


def kept_plan(file: Path, known: Known, digest: str) -> Plan | None:
    """Read a plan if it is there and was made for the inputs of this digest; see `read_plan`.

    A plan of other inputs may name bodies and vibrations that are no more: it is not looked at.

    Parameters
    ----------
    file : of the plan
    known : labels of the vibrations of each flexible body, by mesh
    digest : of the inputs
    """
    if not file.exists():
        return None
    table = read_toml(file, "plan")
    there = table.get("inputs_sha256")
    other = isinstance(there, str) and there != digest
    return None if other else plan_of_table(file, table, known)


def read_plan(file: Path, known: Known) -> Plan:
    """Read a plan.

    Parameters
    ----------
    known : labels of the vibrations of each flexible body, by mesh

    Raises
    ------
    InputError
        File, key, value and expectation of what is wrong.
    """
    return plan_of_table(file, read_toml(file, "plan"), known)


def plan_of_table(file: Path, content: Mapping[str, Any], known: Known) -> Plan:
    """Return the plan of the content of a file.

    Parameters
    ----------
    file : its name for messages
    content : of the TOML file
    known : labels of the vibrations of each flexible body, by mesh

    Raises
    ------
    InputError
        As `read_plan`.
    """
    table = validated(PlanTable, content, file)
    bodies = dict[str, BodyPlan]()
    for name, body in table.bodies.items():
        where = f"{file}: bodies.{name}"
        if name not in known:
            raise InputError(f"{where}: no such flexible body{nearest(name, known)}")
        labels, there = body.vibrations, known[name][body.mesh]
        for i, label in enumerate(labels):
            refuse(unknown(f"{where}.vibrations.{i}", label, "vibration", there))
            if label in labels[:i]:
                raise InputError(f'{where}.vibrations.{i} = "{label}": twice; expected it once')
        bodies[name] = BodyPlan(
            tuple(labels), body.static_shapes, body.ringing, body.mesh, body.whole
        )
    for name in known:
        if name not in bodies:
            raise InputError(
                f"{file}: bodies.{name}: missing; expected a table for each flexible body"
            )
    return Plan(bodies, table.geometric_stiffening, table.rtol, table.inputs_sha256)
