"""Read a case file: merge variants, check every run, resolve names."""

from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from ..errors import InputError, nearest
from ..input import lines, read_toml
from ..input.material import check_materials
from .schema import BeamBody, CaseFile, Mechanism, PackageBody, RigidBody
from .sections import check_section


@dataclass(frozen=True)
class Case:
    """A checked case: its top and one mechanism per run."""

    name: str
    file: Path
    top: CaseFile
    runs: dict[str, Mechanism]


def load_case(file: Path, *, coarse: bool = False) -> Case:
    """Read and check a case file.

    Raises
    ------
    InputError
        Every finding on a line of its own: file, key, value, expectation.
    """
    table = read_toml(file, "case file")
    top_keys = set(CaseFile.model_fields)
    try:
        top = CaseFile.model_validate({k: v for k, v in table.items() if k in top_keys})
    except ValidationError as error:
        raise InputError("\n".join(lines(error, CaseFile, str(file)))) from error
    base = {k: v for k, v in table.items() if k not in top_keys}
    for key in base:
        if key not in Mechanism.model_fields:
            known = [*CaseFile.model_fields, *Mechanism.model_fields]
            raise InputError(f"{file}: {key}: unknown key{nearest(key, known)}")
    problems: list[str] = []
    runs: dict[str, Mechanism] = {}
    for name, run in top.runs.items():
        merged = deepcopy(base)
        for variant in run.variants:
            if variant not in top.variants:
                problems.append(
                    f'{file}: runs.{name}.variants = "{variant}": '
                    f"no such variant{nearest(variant, top.variants)}"
                )
                continue
            merge(merged, top.variants[variant])
        if coarse:
            merge(merged, top.coarse)
        try:
            mechanism = Mechanism.model_validate(merged)
        except ValidationError as error:
            problems += lines(error, Mechanism, str(file))
            continue
        problems += [f"{file}: {p}" for p in cross_check(mechanism, file.parent)]
        runs[name] = mechanism
    for name, figure in top.figures.items():
        for run_name in figure.runs:
            if run_name not in top.runs:
                problems.append(
                    f'{file}: figures.{name}.runs = "{run_name}": '
                    f"no such run{nearest(run_name, top.runs)}"
                )
        for mechanism in runs.values():
            if figure.signal not in mechanism.signals:
                problems.append(
                    f'{file}: figures.{name}.signal = "{figure.signal}": '
                    f"no such signal{nearest(figure.signal, mechanism.signals)}"
                )
    if problems:
        raise InputError("\n".join(dict.fromkeys(problems)))
    return Case(file.resolve().parent.name, file, top, runs)


def merge(base: dict[str, Any], over: dict[str, Any]) -> None:
    """Merge tables of `over` into `base` in place; values and lists are replaced."""
    for key, value in over.items():
        if isinstance(value, dict) and isinstance(base.get(key), dict):
            merge(base[key], value)
        else:
            base[key] = deepcopy(value)


def interfaces(body: BeamBody | RigidBody | PackageBody) -> list[str] | None:
    """Return the interface names of a body; None for a package, whose file knows them."""
    return None if isinstance(body, PackageBody) else list(body.interfaces)


def cross_check(mechanism: Mechanism, folder: Path) -> list[str]:
    """Return what types and bounds alone cannot tell: names that exist, values that fit.

    `folder` is that of the case file.
    """
    found = check_materials(mechanism.materials)
    for name, body in mechanism.bodies.items():
        if isinstance(body, BeamBody):
            found += _check_beam(f"bodies.{name}", body, mechanism, folder)
        elif isinstance(body, RigidBody):
            inertia = np.array(body.inertia)
            if not np.allclose(inertia, inertia.T) or np.linalg.eigvalsh(inertia)[0] <= 0:
                found.append(
                    f"bodies.{name}.inertia = {body.inertia}: expected a symmetric, "
                    "positive definite 3x3 matrix"
                )
    for name, joint in mechanism.joints.items():
        key = f"joints.{name}.between"
        for place in joint.between:
            found += check_place(key, place, mechanism, ground=True)
        if joint.between[0] == joint.between[1]:
            found.append(f"{key} = {joint.between}: expected two different places")
        if joint.kind == "revolute" and not np.linalg.norm(joint.axis) > 0:
            found.append(f"joints.{name}.axis = {joint.axis}: expected a vector of some length")
    for name, mass in mechanism.masses.items():
        found += check_place(f"masses.{name}.at", mass.at, mechanism, ground=False)
    for name, signal in mechanism.signals.items():
        found += check_place(f"signals.{name}.at", signal.at, mechanism, ground=False)
    return found


def _check_beam(key: str, body: BeamBody, mechanism: Mechanism, folder: Path) -> list[str]:
    found = []
    if body.section not in mechanism.sections:
        hint = nearest(body.section, mechanism.sections)
        found.append(f'{key}.section = "{body.section}": no such section{hint}')
    if body.material is not None and body.material not in mechanism.materials:
        hint = nearest(body.material, mechanism.materials)
        found.append(f'{key}.material = "{body.material}": no such material{hint}')
    if not found:
        found += check_section(key, body, mechanism, folder)
    if body.reference.at not in body.interfaces:
        hint = nearest(body.reference.at, body.interfaces)
        found.append(f'{key}.reference.at = "{body.reference.at}": no such interface{hint}')
    x2 = np.array(body.x2_axis)
    if abs(np.linalg.norm(x2) - 1.0) > 1e-9 or abs(x2[0]) > 1e-9:
        found.append(f"{key}.x2_axis = {body.x2_axis}: expected a unit vector normal to body x")
    stops = {i.at if isinstance(i.at, float) else i.at == "end" for i in body.interfaces.values()}
    if body.elements < len(stops | {0.0, 1.0}) - 1:
        found.append(
            f"{key}.elements = {body.elements}: expected at least {len(stops | {0.0, 1.0}) - 1}: "
            "every interface needs a node"
        )
    return found


def check_place(key: str, place: str, mechanism: Mechanism, *, ground: bool) -> list[str]:
    """Return what is wrong with a place "BODY.INTERFACE" or "ground.POINT"."""
    owner, dot, point = place.partition(".")
    if not dot:
        expected = '"BODY.INTERFACE"' + (' or "ground.POINT"' if ground else "")
        return [f'{key} = "{place}": expected {expected}']
    if owner == "ground" and ground:
        if point in mechanism.ground:
            return []
        hint = nearest(point, mechanism.ground)
        return [f'{key} = "{place}": the ground has no point "{point}"{hint}']
    if owner not in mechanism.bodies:
        return [f'{key} = "{place}": there is no body "{owner}"{nearest(owner, mechanism.bodies)}']
    known = interfaces(mechanism.bodies[owner])
    if known is not None and point not in known:
        return [
            f'{key} = "{place}": body "{owner}" has no interface "{point}"{nearest(point, known)}'
        ]
    return []
