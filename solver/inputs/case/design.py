"""A checked case, and the studies of its `[design]`: parameters found in the mechanism, designs as
members of a sweep."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

from ...errors import InputError, nearest, refuse, unknown
from ...math.arrays import Array
from ...package.specification import ModeKind
from ..common.input_table import plain_table
from ..common.text_file import Tables
from ..common.units import LENGTHS
from .bodies.specifications import BodySpec, BodySpecs, rich_bodies
from .checks import in_parts, without_strengths
from .sweeps import CheckedSweep, MergedOf, Misplaced, base_of, check_sweep, number_at, unit_at
from .tables.beam_keys import BeamBody
from .tables.bodies import RigidBody
from .tables.design_keys import MECHANISM, Design, DesignParameter, Limit, Quantity, Study, Target
from .tables.schema import CaseFile, Mechanism, Sweep, Variation, put, split_key

UNITS = {"angle": "deg", "thickness": "m"}  # of the keys of a kind
VIBRATIONS = get_args(ModeKind)


@dataclass(frozen=True)
class CheckedStudy:
    """A study with checked parameters.

    Attributes
    ----------
    name : of the study
    table : its keys
    parameters : those that vary, by name; p of them
    targets : keys of each, with factor and offset
    base : the run without changes
    start : (p,) values at the start, in the unit that the user writes
    merged : the run as the user wrote it, for the digest of what was read
    """

    name: str
    table: Study
    parameters: dict[str, DesignParameter]
    targets: dict[str, list[Target]]
    base: Mechanism
    start: Array
    merged: Tables
    _where: str
    _specs: BodySpecs
    _merged_of: MergedOf

    def unit(self, name: str) -> str:
        """Return the unit of a parameter, "" for none, or of one that a factor scales."""
        parameter, target = self.parameters[name], self.targets[name][0]
        if parameter.kind in UNITS or parameter.names or abs(target.factor) != 1.0:
            return UNITS.get(parameter.kind, "")
        return unit_at(self.base, target.key, self._specs.folder, self._specs.units)

    def designs(self, points: Sequence[Array]) -> CheckedSweep:
        """Return designs (p,) as members of a sweep, all with the same names.

        Raises InputError: a value that is refused.
        """
        columns = dict(zip(self.parameters, np.array(points, dtype=float).T, strict=True))
        vary, texts = dict[str, Variation](), dict[str, str]()
        names = dict[str, str]()
        for name, values in columns.items():
            if self.parameters[name].names:
                chosen = {str(self.parameters[name].shown(value)) for value in values}
                if len(chosen) > 1:
                    raise InputError(f"{self._where}: {name}: designs of several names")
                names |= dict.fromkeys([t.key for t in self.targets[name]], *chosen)
                continue
            plain = [t.key for t in self.targets[name] if (t.factor, t.offset) == (1.0, 0.0)]
            texts |= {
                t.key: f"({t.factor!r})*{name}+({t.offset!r})"
                for t in self.targets[name]
                if t.key not in plain
            }
            own = {"keys": plain} if plain else {}
            vary[name] = Variation.model_validate({**own, "values": values.tolist()})
        if not vary:  # names alone; a study sets the tolerance itself
            values = [self.base.solver.rtol] * len(points)
            vary["solver.rtol"] = Variation.model_validate({"values": values})
        sweep = Sweep.model_validate(
            {"run": self.table.run, "design": "list", "vary": vary, "set": texts}
        )
        merged_of = self._merged_of
        return check_sweep(
            self._where, sweep, self._specs, lambda run: _with_names(merged_of(run), names)
        )

    def keys(self, p: Array) -> dict[str, float | str]:
        """Return the values of the keys of a design (p,)."""
        values: dict[str, float | str] = {}
        for (name, parameter), value in zip(self.parameters.items(), p, strict=True):
            for t in self.targets[name]:
                own = parameter.shown(value)
                values[t.key] = own if isinstance(own, str) else t.factor * own + t.offset
        return values

    def richer(self) -> "CheckedStudy":
        """Return the study of finer bodies: twice the elements, half as many modes again.

        A shell is refined once. A run with `[fidelity]` takes all modes of its check.
        """

        def merged_of(run: str) -> Tables:
            table = self._merged_of(run)
            planned = table.pop("fidelity", None)
            for name, body in table.get("bodies", {}).items():
                kind = body.get("kind")
                if kind not in ("beam", "shell") or body.get("rigid"):
                    continue
                if kind == "beam":
                    body["elements"] = 2 * body.get(
                        "elements", BeamBody.model_fields["elements"].default
                    )
                else:
                    body["refine"] = body.get("refine", 0) + 1
                if planned:
                    rich = rich_bodies(name, self.base)[1].modes
                    body["modes"] = [plain_table(mode) for mode in rich]
                for mode in [] if planned else body.get("modes", []):
                    if "count" in mode and mode["kind"] in VIBRATIONS:
                        mode["count"] = -(-3 * mode["count"] // 2)
            return table

        return replace(self, _merged_of=merged_of)


def _with_names(merged: Tables, names: Mapping[str, str]) -> Tables:
    """Return the tables of a run with names at dotted keys, where it has such a body or section."""
    for key, name in names.items():
        group, owner, *_ = split_key(key)
        if owner in merged.get(group, {}):
            if ":" in key and "changes" not in merged[group][owner]:
                merged = put(merged, {f"{group}.{owner}.changes": {}})
            merged = put(merged, {key: name})
    return merged


@dataclass(frozen=True)
class Case:
    """A checked case.

    Attributes
    ----------
    name : of its folder; of the file, unless that is case.toml
    file : where it comes from
    top : what is beside the mechanism
    runs : mechanism by run
    bodies : specifications of the flexible bodies by run and name
    varied : a further sweep of its runs, checked; messages name it by the first argument
    sweeps : those that were asked for, with all their members
    studies : of the design
    """

    name: str
    file: Path
    top: CaseFile
    runs: dict[str, Mechanism]
    bodies: dict[str, dict[str, BodySpec]]
    varied: Callable[[str, Sweep], CheckedSweep]
    sweeps: dict[str, CheckedSweep] = field(default_factory=dict)
    studies: dict[str, CheckedStudy] = field(default_factory=dict)


def check_study(
    where: str, name: str, design: Design, specs: BodySpecs, merged_of: MergedOf
) -> CheckedStudy:
    """Return a study.

    Parameters
    ----------
    where : file and key of the study
    specs : of the case
    merged_of : mechanism of a run by its name, as the user wrote it, with its variants

    Raises
    ------
    InputError
        One line per finding.
    """
    study = design.studies[name]
    merged = merged_of(study.run)
    base, _ = base_of(where, merged, specs)
    errors: list[str] = []
    for wanted in study.parameters or ():
        errors += unknown(
            f"{where}.parameters", wanted, "parameter of the design", design.parameters
        )
    names = study.parameters or list(design.parameters)
    parameters = {n: design.parameters[n] for n in names if n in design.parameters}
    if not design.parameters:
        errors.append(f"{where}: expected [design.parameters] in the case")
    targets, start = dict[str, list[Target]](), list[float]()
    for parameter_name, parameter in parameters.items():
        at = f"{where.partition(':')[0]}: design.parameters.{parameter_name}"
        listed = [Target(key=t) if isinstance(t, str) else t for t in parameter.of]
        targets[parameter_name] = listed
        if parameter.names:
            try:
                own = number_at(base, listed[0].key, specs.folder, text=True)[1]
            except Misplaced as error:
                errors.append(f"{at}.of: {error}")
                continue
            own = own if parameter.start is None else parameter.start
            if own not in parameter.names:
                words = ", ".join(parameter.names)
                errors.append(f"{at}: the case has {own!r}; expected `start`, one of {words}")
                continue
            start.append(float(parameter.names.index(str(own))))
            continue
        wrong = [line for t in listed for line in _misplaced(at, parameter, t, base, specs)]
        errors += wrong
        if not wrong:
            value: Any = parameter.start
            if value is None:
                first = listed[0]
                there = number_at(base, first.key, specs.folder)[1]
                if there is None:
                    errors.append(f"{at}: {first.key} is absent in this run; expected `start`")
                    continue
                value = (there - first.offset) / (first.factor or 1.0)
            low, high = parameter.range()
            if not low - 1e-12 * abs(low) <= value <= high + 1e-12 * abs(high):
                errors.append(
                    f"{at}: the case has {value:g}, outside {low:g} to {high:g}; expected `start`, "
                    "or bounds around it"
                )
            start.append(float(np.clip(value, low, high)))
    sense = "maximise" if study.minimise is None else "minimise"
    for k, quantity in enumerate(study.quantities()):
        key = f"{where}.subject_to.{k - 1}" if k else f"{where}.{sense}"
        wrong = unknown_subject(key, quantity, base)
        if quantity.subject == "strength" and not wrong:
            body = in_parts(base, specs)[1].get(quantity.name)
            wrong = without_strengths(f'{key}.strength = "{quantity.name}"', body)
        errors += wrong
    refuse(errors)
    checked = CheckedStudy(
        name, study, parameters, targets, base, np.array(start), merged, where, specs, merged_of
    )
    points = [checked.start]
    for k, parameter in enumerate(parameters.values()):
        points += [np.r_[points[0][:k], i, points[0][k + 1 :]] for i in range(len(parameter.names))]
    for point in points:
        checked.designs([point])
    return checked


def _misplaced(
    at: str, parameter: DesignParameter, target: Target, base: Mechanism, specs: BodySpecs
) -> list[str]:
    """Return what is wrong with a target, one line each."""
    try:
        unit = unit_at(base, target.key, specs.folder, specs.units)
        owner = split_key(target.key)
    except Misplaced as error:
        return [f"{at}.of: {error}"]
    if unit in LENGTHS and unit != "m":
        return [f'{at}.of: {target.key} is in {unit}; expected units = "m" to vary a length']
    wanted = UNITS.get(parameter.kind)
    if wanted is not None and unit != wanted:
        return [
            f'{at}.of: {target.key} has the unit "{unit}"; expected {wanted}, as its kind is '
            f'{parameter.kind}, or kind = "number"'
        ]
    if owner[0] == "bodies" and getattr(base.bodies.get(owner[1]), "rigid", False):
        return [
            f"{at}.of: {target.key}: body {owner[1]} is rigid in this run; nothing depends on it"
        ]
    return []


def unknown_subject(key: str, quantity: Quantity, base: Mechanism) -> list[str]:
    """Return what a quantity names and the run does not have, or cannot give.

    Parameters
    ----------
    key : key of the input file, for messages
    quantity : subject and name of an objective or limit
    base : the run that is varied
    """
    name, end = quantity.name, base.solver.t_end
    for time, at in ((quantity.time, "time"), (quantity.low, "from")):
        if time is not None and time > end:
            return [f"{key}.{at} = {time:g}: expected at most solver.t_end = {end:g} s"]
    if quantity.subject == "signal":
        return list(unknown(f"{key}.signal", name, "signal", base.signals))
    whole = quantity.subject in ("frequency", "mass", "deformation_energy")
    if whole and name == MECHANISM:
        return []
    at = f"{key}.{quantity.subject}"
    if name not in base.bodies:
        known = [*base.bodies, *([MECHANISM] if whole else [])]
        return [f"{at} = {name!r}: no such body{nearest(name, known)}"]
    body = base.bodies[name]
    if quantity.subject != "mass" and (isinstance(body, RigidBody) or body.rigid):
        return [f"{at} = {name!r}: the body is rigid in this run"]
    if quantity.subject == "section" and not isinstance(body, BeamBody):
        return [f"{at} = {name!r}: expected a beam"]
    divided = isinstance(body, BeamBody) and body.segments > 1
    if divided and quantity.subject not in ("mass", "section"):
        other = f'"{MECHANISM}"' if whole else 'a signal of kind "exposure"'
        return [f"{at} = {name!r}: expected a body in one segment, or {other}"]
    least = quantity.least if isinstance(quantity, Limit) else None
    if quantity.subject == "strength" and least is not None and least <= 0.0:
        return [f"{at}: min = {least:g}: expected a ratio above 0"]
    return []
