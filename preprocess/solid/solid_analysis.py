"""Results of the command `solid`: inertia, frequencies with their errors, load cases."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ...solver.errors import InputError, coded
from ...solver.math.arrays import Array
from ...solver.package import ModalPackage
from ...solver.package.body.plausibility import centre_inertia
from ..exchange.direct import Solver
from ..exchange.free_body import FreeBody
from ..exchange.import_table import SI, InterfaceTable
from ..exchange.imported_interfaces import Constrained, constrained, links
from ..exchange.reduce import reduce_body
from ..fenicsx.team import ALONE, Team
from ..modes.reference import Algebra, HeldDofs
from .model import MOST_FACTORISED, Mumps, SolidModel
from .solid_mesh import FINER, SolidError, edge_length
from .tolerances import COARSE, MOST, RICHER

COMPARED = 6  # frequencies that `accuracy` is about
ROUNDS = 5  # meshes that `accuracy` may take
LARGEST = 1e100  # [m] displacement: strains of steel are below 1e-2


class Case(NamedTuple):
    """Results of a load case."""

    u: Array  # (n, 3) displacements [m]
    reactions: dict[str, list[float]]  # of each support, about its reference point [N, N m]


class HeldSolid:
    """A solid with its rigid interfaces, held at some of them."""

    def __init__(
        self,
        body: FreeBody,
        tables: Mapping[str, InterfaceTable],
        supports: list[str],
        solver: Callable[[Constrained], Solver] = Mumps,
    ) -> None:
        """`tables` are those of the interfaces, see SolidModel.links."""
        try:
            self._links = {link.name: link for link in links(body, tables, 1.0)}
            parts = constrained(body, list(self._links.values()))
        except InputError as error:
            raise SolidError(str(error).removeprefix(": ")) from error
        self._body, self._T = body, parts.T
        self._of_support = {name: parts.reference_dofs[name] for name in supports}
        self._K = parts.T.T @ body.K @ parts.T
        self._solver = solver(parts)
        self._condition = HeldDofs(
            self._K,
            parts.T.T @ body.M @ parts.T,
            np.concatenate(list(self._of_support.values())),
            Algebra(self._solver.solve, self._solver.negative_pivots),
        )
        self._solver.add_subset(self._condition.free)

    def hertz(self, count: int) -> Array:
        """Lowest frequencies [Hz]."""
        return _hertz(self._condition.lowest(count, self._solver.eigenpairs)[0])

    def case(
        self, loads: Mapping[str, Any], unit_pressure: Callable[[str], Array], where: str = "loads"
    ) -> Case:
        """Static displacements under the loads of a case.

        Parameters
        ----------
        loads : tables by name: gravity [m/s2], force [N], moment [N m], pressure [Pa]
        unit_pressure : see `SolidModel`
        where : key of the case, for messages

        Raises
        ------
        SolidError
            The displacements overflow.
        """
        f = np.zeros(self._T.shape[0])
        for load in loads.values():
            if "gravity" in load:
                f += self._body.M @ np.tile(load["gravity"], len(self._body.nodes))
            else:
                wrench = [*load.get("force", [0.0] * 3), *load.get("moment", [0.0] * 3)]
                f += self._links[load["at"]].motion.T @ np.array(wrench)
                if "pressure" in load:
                    f += load["pressure"] * unit_pressure(load["at"])
        reduced = (self._T.T @ f)[:, None]
        columns = self._condition.static(reduced, np.zeros_like(reduced)).columns
        if not np.abs(columns).max(initial=0.0) < LARGEST:  # nor NaN
            raise SolidError(f"{where}: its displacements overflow; expected smaller loads")
        reaction = (self._K @ columns - reduced)[:, 0]
        return Case(
            np.asarray(self._T @ columns).reshape(-1, 3),
            {name: reaction[own].tolist() for name, own in self._of_support.items()},
        )


def free_hertz(
    body: FreeBody, count: int, solver: Callable[[Constrained], Solver] = Mumps
) -> Array:
    """Lowest elastic frequencies of the free solid, without rigid interfaces [Hz].

    Parameters
    ----------
    count : number of frequencies
    solver : see SolidModel.solver
    """
    package = reduce_body(
        body,
        {
            "body": "free",
            "reference": {"kind": "mean-axis"},
            "modes": [{"kind": "lowest", "count": count}],
            "interfaces": {},
            "units": SI,
        },
        solver=solver,
    )
    return np.asarray(package.frequencies / (2.0 * np.pi))


def _richer_hertz(model: SolidModel) -> Array:
    found: Array = model.team.first(lambda: free_hertz(model.richer(), COMPARED))
    return found


def _hertz(values: Array) -> Array:
    return np.asarray(np.sqrt(values) / (2.0 * np.pi))


def accurate_model(
    solid: Mapping[str, Any],
    interfaces: Mapping[str, Any],
    where: str = "",
    team: Team = ALONE,
) -> SolidModel:
    """The model with cells of the requested size, or with frequencies of the requested accuracy.

    Parameters
    ----------
    solid, interfaces, where, team : see SolidModel

    Raises SolidError if the accuracy is not reached with `ROUNDS` meshes, or with those whose
    errors are estimated by at most `MOST_FACTORISED` unknowns.
    """
    model = SolidModel(solid, interfaces, where, team=team)
    wanted = solid["mesh"].get("accuracy")
    if wanted is None:
        return model
    size, error = model.mesh.size, np.inf
    for number in range(ROUNDS):
        if number:  # errors of frequencies fall with the fourth power of the size at most
            size /= max(FINER, (error / wanted) ** 0.25)
            model = SolidModel(solid, interfaces, where, size, team)
        unknowns = RICHER * 3 * len(model.mesh.plain.points)
        if unknowns > MOST_FACTORISED:
            raise SolidError(
                f"{model.described}mesh.accuracy = {wanted:g}: the error with cells of {size:.3g} "
                f"m takes {unknowns:.2g} unknowns of degree 3; expected at most {MOST_FACTORISED}: "
                f"a larger value (that of the mesh before is {error:.2g}), or a larger mesh.size"
            )
        hertz = free_hertz(model.body, COMPARED, model.solver)
        error = max(map(abs, _relative(hertz, _richer_hertz(model))))
        if error <= wanted:
            return model
    raise SolidError(
        f"{model.described}mesh.accuracy = {wanted:g}: not reached with cells of "
        f"{size:.3g} m, the estimated error is {error:.2g}; expected a larger value, or a "
        "part without sharp edges inwards"
    )


def findings(
    model: SolidModel, package: ModalPackage, table: Mapping[str, Any]
) -> tuple[dict[str, object], dict[str, Array]]:
    """Numbers of a solid as plain data, SI, and displacements (n, 3) of its load cases.

    Parameters
    ----------
    package : of the free solid, with as many modes as frequencies are asked for
    table : `SolidAnalysis` of the specification
    """
    inv = package.invariants
    table_of_results: dict[str, object] = {
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
    count, cases = package.n_mode, {}
    if table["supports"]:
        held = HeldSolid(model.body, model.links, table["supports"], model.solver)
        table_of_results["held_hz"] = held.hertz(count).tolist()
        solved = {
            name: held.case(loads, model.unit_pressure, f"loads.{name}")
            for name, loads in table["loads"].items()
        }
        cases = {name: case.u for name, case in solved.items()}
        table_of_results["cases"] = {name: _case(model, case) for name, case in solved.items()}
    table_of_results |= model.team.first(lambda: _errors(model, table, table_of_results, count))
    return table_of_results, cases


def _errors(
    model: SolidModel, table: Mapping[str, Any], results: Mapping[str, Any], count: int
) -> dict[str, object]:
    """Relative errors of the frequencies by displacements of degree 3, or why there are none."""
    if not table["error"]:
        return {"no_error": "frequencies.error = false"}
    if results["unknowns"] > MOST:
        return {"no_error": f"{results['unknowns']} unknowns, more than {MOST}"}
    richer = model.richer()
    errors: dict[str, object] = {
        "free_error": _relative(results["free_hz"], free_hertz(richer, count))
    }
    if "held_hz" in results:
        rigid: dict[str, InterfaceTable] = {
            name: {**link, "weights": "equal"}  # they place reference points, which change nothing
            for name, link in model.links.items()
            if link["link"] == "rigid"
        }
        held = HeldSolid(richer, rigid, table["supports"])
        errors["held_error"] = _relative(results["held_hz"], held.hertz(count))
    return errors


def coarse_mesh(results: Mapping[str, Any]) -> list[dict[str, str]]:
    """Warn of frequencies and static deflections whose errors are large.

    A deflection is too small by about twice the error of the first frequency of the held part.
    """
    errors = {name: results.get(f"{name}_error", [0.0]) for name in ("free", "held")}
    worst = max(abs(e) for own in errors.values() for e in own)
    static = 2.0 * errors["held"][0] if results.get("cases") else 0.0
    if max(worst, static) <= COARSE:
        return []
    text = f"frequencies are up to {100.0 * worst:.2g} % too high by the mesh"
    if static > COARSE:
        text += f", deflections about {100.0 * static:.2g} % too small"
    return coded("solid-mesh-coarse", f"{text}; use smaller cells: size or accuracy in [mesh]")


def _relative(hertz: Array | list[float], richer: Array) -> list[float]:
    """Estimated error of frequencies, too high above 0: those of degree 3 are nearly exact."""
    return list((np.array(hertz) / richer - 1.0).tolist())


def _exact(model: SolidModel) -> dict[str, object] | None:
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


def _case(model: SolidModel, case: Case) -> dict[str, object]:
    """The largest displacement of a load case, and its reactions."""
    size = np.linalg.norm(case.u, axis=1)
    node = int(np.argmax(size))
    return {
        "displacement": float(size[node]),
        "at": model.mesh.plain.points[node].tolist(),
        "reactions": case.reactions,
    }
