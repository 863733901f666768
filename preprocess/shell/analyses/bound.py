"""Bounds of a lowest frequency, a load factor and a compliance over all lay-ups of given plies.

Lay-ups have the plies of the laminate, each at any angle a. The stiffness of a ply has the
harmonics t = (cos 2a, sin 2a, cos 4a, sin 4a), so A, B and D are affine in twelve lamination
parameters p (Tsai and Hahn 1980), and so is the stiffness K of triangles without transverse shear.
That of quadrilaterals is concave: its linearisation about any p is above it. With W the mass
(frequency squared), minus the geometric stiffness (load factor), or f f' of a load (1/compliance),

    lambda(p) = min x' K(p) x / (x' W x)   over x with x' W x > 0,

and each x gives a linear function of p that is nowhere below lambda. Mixtures enlarge the set of
lay-ups: each ply has shares of many angles, and p is in the convex hull of that of lay-ups. With
factors s_i >= 0 of sum 1,

    lambda <= max_p sum_i s_i x_i' K(p) x_i / (x_i' W x_i) = c + sum over plies of max_a g(a),

g a combination of the four harmonics. Its maximum on a fine grid and the largest error between the
points of the grid bound that over all angles. A linear program finds the factors and the best
mixture for some x (cutting planes), an eigenproblem in a basis of modes the next x; modes of the
whole shell for the best mixture extend the basis until both agree.

Transverse shear makes a shell softer, so the bound is one of shells with it, too.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ....solver.math.arrays import Array
from ..elements.membranes.opt import best_beta0
from ..model.shell_problem import ShellProblem
from ..model.shell_warnings import Progress, check_supported
from ..shell_cells import ShellError
from .branches import best_of_angles
from .buckling import Buckling, Stressed
from .cases import solve_cases
from .frequencies import natural_modes
from .mixtures import AGREED, MODES, Basis, Cuts, Plies
from .modes import as_columns, free_or_held

RIGID = 1e6  # transverse shear stiffness over the in-plane one
NEAR = 2e-4  # relative difference of the basis
MOST_CUTS, MOST_BASES = 150, 15  # iterations
FLIPS = 4  # starts of the search with other signs of the angles
TURNS = ([10.0 * k for k in range(1, 18)], [-5.0, 5.0], [-2.0, 2.0], [-1.0, 1.0])  # of the search
SAME = 1e-6  # relative difference of resultants by rounding


def _searched(basis: Basis, plies: Plies, angles_deg: Array) -> Array:
    """Angles (g,) of a large lambda near some, turned one by one."""
    best, most = angles_deg, basis.value(plies.parameters(angles_deg))
    for turns in TURNS:
        better = True
        while better:
            better = False
            for k in range(len(best)):
                tried = np.repeat(best[None], len(turns), axis=0)
                tried[:, k] += turns
                values = [basis.value(plies.parameters(each)) for each in tried]
                if max(values) > most * (1.0 + AGREED):
                    best, most, better = tried[int(np.argmax(values))], max(values), True
    return np.round(_turned(best), 9)


class Quantity(NamedTuple):
    """What is bounded.

    Attributes
    ----------
    modes : lambda (m,) and x (n_dof, m) of a stiffness
    weighed : x' W x of some x (n_dof, m), (m, m)
    shown : what a user reads of lambda
    unit, case : its unit and its load case
    """

    modes: Callable[[sp.csr_matrix], tuple[Array, Array]]
    weighed: Callable[[Array], Array]
    shown: Callable[[float], float]
    unit: str
    case: str | None


def frequency(stressed: Stressed, where: str) -> Quantity:
    """The lowest frequency with strain energy, of the shell without prestress."""
    problem = stressed.problem
    table = problem.spec.get("frequencies", {})
    if table.get("prestress") is not None:
        raise ShellError(f"{where} = 'frequency': expected no frequencies.prestress")
    M, (freedom, *motions) = problem.M, free_or_held(problem, table.get("free", False))
    free_motions = as_columns(freedom, *motions)

    def modes(K: sp.csr_matrix) -> tuple[Array, Array]:
        vibrations = natural_modes(K, M, freedom, MODES, free_motions)
        return vibrations.values[vibrations.n_zero :], vibrations.shapes[:, vibrations.n_zero :]

    def hertz(value: float) -> float:
        return float(np.sqrt(value)) / (2.0 * np.pi)

    return Quantity(modes, lambda X: X.T @ (M @ X), hertz, "Hz", None)


def load_factor(stressed: Stressed, where: str) -> Quantity:
    """The first load factor under a load case whose resultants no lay-up changes."""
    problem, table = stressed.problem, stressed.problem.spec.get("buckling", {})
    case, in_plane = _case(stressed, table.get("cases"), where), table.get("in_plane", True)
    if table.get("constant") is not None:
        raise ShellError(f"{where} = 'buckling': expected no buckling.constant")
    loads, rng = {case: problem.spec["loads"][case]}, np.random.default_rng(0)
    f, given = problem.loads.columns(loads, problem.where)
    N = problem.resultants(stressed.u[:, [stressed.names.index(case)]])[0, :, :3]
    for _ in range(2):
        plies = len(problem.regions[0].laminate.laminate.plies)
        other = turned(problem, dict(enumerate(rng.uniform(-90.0, 90.0, plies))))
        u = solve_cases(other.K, problem.freedom, f, (case,), given=given).displacements
        if np.abs(other.resultants(u)[0, :, :3] - N).max() > SAME * np.abs(N).max():
            raise ShellError(
                f"{where} = 'buckling': the stresses of load case {case} depend on the lay-up, "
                "and its load factor has no such bound; expected loads on edges, and supports "
                "that do not hinder the contraction (docs/shells.md)"
            )
    freedom, Kg = problem.modes_freedom, stressed.geometric(case, where, in_plane)
    check_supported(freedom, *problem.free_motions(freedom))

    def modes(K: sp.csr_matrix) -> tuple[Array, Array]:
        equations = Buckling(K, freedom, where)
        factors = equations.load_factors(Kg, MODES, where)
        equations.close()
        if not len(factors.values):
            raise ShellError(f"{where} = 'buckling': no buckling under load case {case}")
        return factors.values, factors.shapes

    return Quantity(modes, lambda X: -(X.T @ (Kg @ X)), float, "", case)


def compliance(stressed: Stressed, where: str) -> Quantity:
    """The work f'u of a load case."""
    problem, case = stressed.problem, _case(stressed, None, where)
    loads = {case: problem.spec["loads"][case]}
    f, given = problem.loads.columns(loads, problem.where)
    if given is not None and given.any():
        raise ShellError(f"{where} = 'compliance': load case {case} has a motion; expected forces")

    def modes(K: sp.csr_matrix) -> tuple[Array, Array]:
        u = solve_cases(K, problem.freedom, f, (case,)).displacements
        return 1.0 / (f.T @ u)[0], u

    return Quantity(modes, lambda X: (X.T @ f) @ (f.T @ X), lambda value: 1.0 / value, "J", case)


QUANTITIES = {"frequency": frequency, "buckling": load_factor, "compliance": compliance}


def _case(stressed: Stressed, cases: list[str] | None, where: str) -> str:
    names = list(stressed.names) if cases is None else cases
    if len(names) != 1:
        raise ShellError(f"{where}: expected one load case, found {', '.join(names) or 'none'}")
    return names[0]


def turned(problem: ShellProblem, angles_deg: Mapping[int, float]) -> ShellProblem:
    """A shell of one laminate with other angles of some plies, by their rows."""
    name = problem.regions[0].laminate_name
    laminates = problem.spec["laminates"]
    plies = [dict(ply) for ply in laminates[name]["plies"]]
    for row, angle in angles_deg.items():
        plies[row]["angle_deg"] = float(angle)
    changed = {**laminates, name: {**laminates[name], "plies": plies}}
    return problem.relaid({**problem.spec, "laminates": changed})


def _check(problem: ShellProblem, where: str) -> None:
    names = sorted({region.laminate_name for region in problem.regions})
    if len(names) > 1 or names[0] not in problem.spec.get("laminates", {}):
        raise ShellError(f"{where}: expected one laminate of plies, found {', '.join(names)}")
    if problem.stiffeners:
        raise ShellError(f"{where}: expected a shell without stiffeners")
    if problem.team.size > 1:
        raise ShellError(f"{where}: expected one process, found {problem.team.size}")
    if problem.choice.plate not in ("dkmt", "dkt"):
        raise ShellError(f"{where}: expected elements.plate = dkmt or dkt")


def bound(stressed: Stressed, of: str, begin: Progress) -> dict[str, object]:
    """A bound of a quantity over all lay-ups, and a lay-up near it, as plain data.

    Parameters
    ----------
    of : key of QUANTITIES

    Raises
    ------
    ShellError : a shell or a quantity that has no such bound, by name.
    """
    problem = stressed.problem
    where = f"{problem.where}.bound"
    _check(problem, where)
    laminate = problem.regions[0].laminate.laminate
    plies = Plies(laminate)
    if not plies.rows:
        raise ShellError(f"{where}: no ply has a direction; expected an orthotropic material")
    quantity = QUANTITIES[of](stressed, where)
    begin(f"bound of {of}")
    choice = problem.choice._replace(plate="dkmt")
    if isinstance(choice.beta0, str):  # its largest value is that of p = 0
        choice = choice._replace(beta0=float(best_beta0(plies.mean[:1])[0]))

    def stiffness(p: Array) -> sp.csr_matrix:
        rigid = RIGID * plies.mean[0, 2, 2] * np.eye(2)
        return problem.stiffness_of((*plies.stiffness(p), rigid), choice)

    def slopes(p: Array) -> dict[int, sp.csr_matrix]:
        return {
            j: (stiffness(p + step) - stiffness(p - step)) / (2.0 * step[j])
            for j, step in steps.items()
        }

    size = np.abs(plies.columns).max(axis=2).sum(axis=0)
    steps = {int(j): 1e-3 * size[j] * np.eye(12)[j] for j in np.flatnonzero(size)}
    affine = all(region.nodes.shape[1] == 3 for region in problem.regions)
    best = np.array([laminate.plies[rows[0]].angle_deg for rows in plies.rows])
    value, X = quantity.modes(problem.K)
    values, more = quantity.modes(stiffness(plies.parameters(best)))
    X, most = np.c_[X, more], float(values[0])
    cuts, p, least = Cuts(plies), np.zeros(12), np.inf
    linear = p, stiffness(p), slopes(p)
    for _ in range(MOST_BASES):
        K = stiffness(p)
        values, more = quantity.modes(K)
        if least < values[0] * (1.0 + NEAR):
            break
        X = np.c_[X, more]
        if p.any() and not affine:
            linear = p, K, slopes(p)
        basis = Basis(X, quantity.weighed(X), *linear)
        for _ in range(MOST_CUTS):
            cuts.add(*basis.cuts(p))
            mixture = cuts.best()
            p, least = mixture.p, min(least, mixture.bound)
            if least < basis.value(p) * (1.0 + AGREED):
                break
    rng = np.random.default_rng(0)
    for near in (False, True):  # with the modes of the lay-up that was found
        basis = Basis(X, quantity.weighed(X), *linear)
        start = best if near else np.round(mixture.angles_deg)
        signs = rng.choice([-1.0, 1.0], (FLIPS, start.size))  # a mixture does not tell them
        tried = [_searched(basis, plies, each) for each in (start, *(signs * start))]
        angles = max(tried, key=lambda each: basis.value(plies.parameters(each)))
        values, more = quantity.modes(stiffness(plies.parameters(angles)))
        X = np.c_[X, more]
        if values[0] > most:
            best, most = angles, float(values[0])

    def laid(angles_deg: Array) -> ShellProblem:
        groups = zip(plies.rows, angles_deg, strict=True)
        return turned(problem, {row: angle for rows, angle in groups for row in rows})

    other = laid(best)
    reached = quantity.modes(other.K)[0]
    if reached[0] < value[0]:  # by transverse shear
        other, reached = problem, value
    gaps = {"gap": value[0], "found_gap": reached[0], "found_gap_without_shear": most}
    limit = quantity.shown(least)
    discrete = None
    if allowed_deg := problem.spec.get("bound_angles_deg"):
        begin(f"best {of} of given angles")
        allowed = np.unique(_turned(np.array(allowed_deg, dtype=float)))
        apart = np.abs((best[:, None] - allowed + 90.0) % 180.0 - 90.0)
        top = best_of_angles(
            plies,
            cuts,
            lambda X: Basis(X, quantity.weighed(X), *linear),
            lambda angles_deg: quantity.modes(laid(angles_deg).K),
            X,
            allowed,
            allowed[apart.argmin(axis=1)],
        )
        discrete = {
            "allowed_deg": allowed_deg,
            "best": quantity.shown(top.value),
            "gap": abs(quantity.shown(top.value) / quantity.shown(top.bound) - 1.0),
            "angles_deg": _angles(laid(top.angles_deg)),
            "lay_ups": len(allowed) ** len(plies.rows),
            "branches": top.branches,
            "computed": top.computed,
        }
    return {
        **{"of": of, "case": quantity.case, "unit": quantity.unit, "symmetric": plies.symmetric},
        **{"bound": limit, "value": quantity.shown(float(value[0]))},
        "found": quantity.shown(float(reached[0])),
        **{key: abs(quantity.shown(float(v)) / limit - 1.0) for key, v in gaps.items()},
        "found_angles_deg": _angles(other),
        "of_angles": discrete,
    }


def _angles(problem: ShellProblem) -> list[float]:
    return [ply.angle_deg for ply in problem.regions[0].laminate.laminate.plies]


def _turned(angles_deg: Array) -> Array:
    """The same directions, above -90 and up to 90 degrees."""
    return 90.0 - (90.0 - angles_deg) % 180.0
