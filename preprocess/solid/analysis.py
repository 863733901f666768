"""What the command `solid` tells: inertia, frequencies with their errors, load cases."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ...solver.errors import InputError
from ...solver.math.arrays import Array
from ...solver.package import ModalPackage
from ...solver.package.body.plausibility import centre_inertia
from ..exchange.links import constrained, links
from ..exchange.reduce import reduce_body
from ..exchange.spec import SI
from ..modes import Algebra, HeldDofs
from .errors import SolidError
from .mesh import edge_length
from .model import Mumps, SolidModel
from .recovery import face_stress

FINER = 1.5  # size of the cells over that of the second mesh
# Errors of frequencies fall with the fourth power of the size in smooth solids, with the first to
# second power where edges inwards have singular stresses. The square is between them.
ERROR = FINER**2 / (FINER**2 - 1.0)  # of the first mesh over the difference
MOST = 60_000  # unknowns of which the second mesh, four times as many, is not left out
COMPARED = 6  # frequencies that `accuracy` is about
ROUNDS = 5  # meshes that `accuracy` may take
LARGEST = 1e100  # [m] displacement: strains of steel are below 1e-2
ORDER = 2.0  # power of the size with which `accuracy` expects errors to fall


class Case(NamedTuple):
    """Results of a load case."""

    u: Array  # (n, 3) displacements [m]
    reactions: dict[str, list[float]]  # of each support, about its reference point [N, N m]


class HeldSolid:
    """A solid with its rigid interfaces, held at some of them."""

    def __init__(self, model: SolidModel, supports: list[str]) -> None:
        body = model.body
        try:
            self._links = {link.name: link for link in links(body, model.links, 1.0)}
            parts = constrained(body, list(self._links.values()))
        except InputError as error:
            raise SolidError(str(error)) from error
        self._body, self._T = body, parts.T
        self._of_support = {name: parts.reference_dofs[name] for name in supports}
        self._K = parts.T.T @ body.K @ parts.T
        self._solver = Mumps(parts.places)
        self._condition = HeldDofs(
            self._K,
            parts.T.T @ body.M @ parts.T,
            np.concatenate(list(self._of_support.values())),
            Algebra(self._solver.solve, self._solver.negative_pivots),
        )

    def hertz(self, count: int) -> Array:
        """Lowest frequencies [Hz]."""
        return _hertz(self._condition.lowest(count, self._solver.eigenpairs)[0])

    def case(self, loads: Mapping[str, Any], where: str = "loads") -> Case:
        """Static displacements under the loads of a case; `where`: its key, for messages."""
        f = np.zeros(self._T.shape[0])
        for load in loads.values():
            if "gravity" in load:
                f += self._body.M @ np.tile(load["gravity"], len(self._body.nodes))
            else:
                wrench = [*load.get("force", [0.0] * 3), *load.get("moment", [0.0] * 3)]
                f += self._links[load["at"]].motion.T @ np.array(wrench)
        reduced = (self._T.T @ f)[:, None]
        columns = self._condition.static(reduced, np.zeros_like(reduced)).columns
        if not np.abs(columns).max(initial=0.0) < LARGEST:  # nor NaN
            raise SolidError(f"{where}: its displacements overflow; expected smaller loads")
        reaction = (self._K @ columns - reduced)[:, 0]
        return Case(
            np.asarray(self._T @ columns).reshape(-1, 3),
            {name: reaction[own].tolist() for name, own in self._of_support.items()},
        )


def free_hertz(model: SolidModel, count: int) -> Array:
    """Lowest elastic frequencies of the free solid, without rigid interfaces [Hz]."""
    found = reduce_body(
        model.body,
        {
            "body": "free",
            "reference": {"kind": "mean-axis"},
            "modes": [{"kind": "lowest", "count": count}],
            "interfaces": {},
            "units": SI,
        },
        solver=Mumps,
    )
    return np.asarray(found.frequencies / (2.0 * np.pi))


def _hertz(values: Array) -> Array:
    return np.asarray(np.sqrt(values) / (2.0 * np.pi))


def accurate_model(
    solid: Mapping[str, Any], interfaces: Mapping[str, Any], where: str
) -> SolidModel:
    """The model with cells of the requested size, or with frequencies of the requested accuracy.

    Raises SolidError if the accuracy is not reached with `ROUNDS` meshes.
    """
    model = SolidModel(solid, interfaces, where)
    wanted = solid["mesh"].get("accuracy")
    if wanted is None:
        return model
    size = solid["mesh"].get("size") or edge_length(model.mesh)
    coarse = free_hertz(model, COMPARED)
    for _ in range(ROUNDS):
        size /= FINER
        model = SolidModel(solid, interfaces, where, size)
        fine = free_hertz(model, COMPARED)
        error = float(np.abs(coarse / fine - 1.0).max()) * (ERROR - 1.0)  # of the finer one
        if error <= wanted:
            return model
        coarse = fine
    raise SolidError(
        f"{where}.mesh.accuracy = {wanted:g}: not reached with cells of {size:.3g} m, the "
        f"estimated error is {error:.2g}; expected a larger value, or a part without sharp edges "
        "inwards"
    )


def findings(
    model: SolidModel, package: ModalPackage, table: Mapping[str, Any], solid: Mapping[str, Any]
) -> dict[str, Any]:
    """Numbers of a solid as plain data, SI.

    Parameters
    ----------
    package : of the free solid, with as many modes as frequencies are asked for
    table : `SolidAnalysis` of the specification
    """
    inv = package.invariants
    found: dict[str, Any] = {
        "mass": inv.mass,
        "centre": (inv.S0_B / inv.mass).tolist(),
        "inertia": centre_inertia(package).tolist(),
        "exact": _exact(model),
        "unknowns": 3 * len(model.mesh.plain.points),
        "cells": len(model.mesh.plain.cells),
        "cell": model.mesh.plain.cell,
        "size": edge_length(model.mesh),
        "free_hz": (package.frequencies / (2.0 * np.pi)).tolist(),
    }
    held = HeldSolid(model, table["supports"]) if table["supports"] else None
    count = package.n_mode
    if held is not None:
        found["held_hz"] = held.hertz(count).tolist()
        found["cases"] = {
            name: _case(model, held.case(loads, f"loads.{name}"), solid)
            for name, loads in table["loads"].items()
        }
    found |= _errors(model, table, solid, found, count)
    return found


def _errors(
    model: SolidModel,
    table: Mapping[str, Any],
    solid: Mapping[str, Any],
    found: Mapping[str, Any],
    count: int,
) -> dict[str, Any]:
    """Relative errors of the frequencies by a second mesh, or why there are none."""
    if not table["error"]:
        return {"no_error": "frequencies.error = false"}
    if not model.mesh.exact:
        return {"no_error": "a mesh or script has no size of cells that could be changed"}
    if found["unknowns"] > MOST:
        return {"no_error": f"{found['unknowns']} unknowns, more than {MOST}"}
    size = solid["mesh"].get("size") or found["size"]
    finer = SolidModel(solid, model.interfaces, model.where, size / FINER)
    errors = {"free_error": _relative(found["free_hz"], free_hertz(finer, count))}
    if "held_hz" in found:
        held = HeldSolid(finer, table["supports"])
        errors["held_error"] = _relative(found["held_hz"], held.hertz(count))
    return errors


def _relative(hertz: list[float], finer: Array) -> list[float]:
    """Estimated error of frequencies, too high above 0."""
    return list((ERROR * (np.array(hertz) / finer - 1.0)).tolist())


def _exact(model: SolidModel) -> dict[str, Any] | None:
    """Mass, centre and inertia of the exact geometry; None without a CAD file."""
    parts = model.mesh.exact
    if not parts:
        return None
    density = np.array(
        [
            model.materials.rho[np.argmax(model.mesh.plain.region == i)]
            for i in range(len(model.mesh.plain.regions))
        ]
    )
    m = density * [part.volume for part in parts]
    x = np.array([part.centre for part in parts])
    c = m @ x / m.sum()
    J = np.einsum("p,pij->ij", density, [part.inertia for part in parts])
    for mass, arm in zip(m, x - c, strict=True):
        J += mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return {"mass": float(m.sum()), "centre": c.tolist(), "inertia": J.tolist()}


def _case(model: SolidModel, case: Case, solid: Mapping[str, Any]) -> dict[str, Any]:
    """The largest displacement and stress of a load case, and the lowest strength ratio."""
    size = np.linalg.norm(case.u, axis=1)
    node = int(np.argmax(size))
    stress = face_stress(model, case.u[:, :, None])[:, :, 0]
    n, t = stress[:, :3], stress[:, 3:]
    mises = np.sqrt(0.5 * ((n - np.roll(n, 1, axis=1)) ** 2).sum(axis=1) + 3.0 * (t**2).sum(axis=1))
    face = int(np.argmax(mises))
    found = {
        "displacement": float(size[node]),
        "at": model.mesh.plain.points[node].tolist(),
        "mises": float(mises[face]),
        "mises_at": model.mesh.plain.points[model.mesh.corners[face]].mean(axis=0).tolist(),
        "reactions": case.reactions,
    }
    names = np.array(model.materials.names)[model.mesh.plain.region[model.mesh.owner]]
    ratios = [
        float(solid["materials"][name]["strength"]["yield_stress"] / mises[names == name].max())
        for name in np.unique(names)
        if "yield_stress" in solid["materials"][name].get("strength", {})
    ]
    if ratios:
        found["strength_ratio"] = min(ratios)
    return found
