"""Map of where each method breaks: growth per step, feedback, undamped index 3.

make stability

Every dot is a run of the product with fixed steps, every line theory: roots of the formulae,
stability functions of the tableaux, eigenvalues of the amplification matrix. Writes
build/charts/stability.csv and docs/pictures/stability.png. Takes about a minute.
"""

import csv
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from samples.constraint_runs import new_run, prepared
from samples.flexible_samples import Points, body_of
from samples.mechanism_samples import Sample, pendulum

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import assemble, constraint_rates
from plymotion.solver.integrators.generic.base import Integrator
from plymotion.solver.integrators.table import FOR_EQUATIONS, new_integrator
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.tables import JointTable, MarkerTable
from plymotion.solver.package.common.files import temporary_sibling
from plymotion.solver.report.style import INK, WARNING, Canvas, colour, house_style

H = 0.02  # s, of the pendulum's runs
T_END = 4.0
BDF_ORDERS = (1, 2, 3, 4, 5, 6)
RADII = (0.0, 0.5, 0.8, 1.0)
EXPLICIT = {"rk5": (FOR_EQUATIONS["rk5"], 3.307), "rk8": (FOR_EQUATIONS["rk8"], 6.396)}  # real axis
CAP = 1e3  # of a drawn growth
# Radau IIA of order 5: Pade (2, 3), for any code of that method.
RADAU = ([1.0, 2 / 5, 1 / 20], [1.0, -3 / 5, 3 / 20, -1 / 60])


@dataclass(frozen=True)
class Row:
    """One run, and what theory says of it."""

    panel: str
    method: str
    parameter: float
    x: float
    measured: float
    theory: float


def _seen(made: Integrator, what: Callable[[Integrator], float]) -> np.ndarray:
    values = []
    while made.status == "running":
        before = made.counters.steps
        made.step()
        if made.counters.steps > before:
            values.append(what(made))
    return np.array(values)


def _amplitude(made: Integrator) -> float:
    return float(np.hypot(made.y[0], made.y[1]))


def _of_mode(made: Integrator) -> float:
    """Amplitude of the mode of `_spring`."""
    return float(np.hypot(made.y[7], made.y[14]))


def _oscillator(t: float, y: np.ndarray) -> np.ndarray:
    return np.array([y[1], -y[0]])


def _per_step(values: np.ndarray) -> float:
    """Growth per step over the later half, before rounding takes over a decay."""
    values = values[: int(np.argmax(values < 1e-250))] if (values < 1e-250).any() else values
    n = max(values.size // 2, 1)
    return float((values[-1] / values[-1 - n]) ** (1 / n)) if values.size > n else np.nan


def bdf_theory(order: int, w_h: float) -> float:
    """Largest root of the formula on y' = i w y."""
    k = order
    steps = np.zeros(k + 1)
    for j in range(1, k + 1):  # sum of backward differences / j
        difference = np.array([1.0])
        for _ in range(j):
            difference = np.convolve(difference, [1.0, -1.0])
        steps[: j + 1] += difference / j
    polynomial = steps.astype(complex)
    polynomial[0] -= 1j * w_h
    return float(np.abs(np.roots(polynomial)).max())


def explicit_theory(kind: Any, z: complex) -> float:
    """Modulus of the stability function of a tableau."""
    A, B = kind.tableau.A, kind.tableau.B
    s = B.size
    return float(abs(1 + z * B @ np.linalg.solve(np.eye(s) - z * A, np.ones(s))))


def alpha_theory(rho: float, w_h: float) -> float:
    """Spectral radius of generalized-alpha's step for (y, h v, h^2 a)."""
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    new = [[1, 0, -beta], [0, 1, -gamma], [(1 - alpha_f) * w_h**2, 0, 1 - alpha_m]]
    old = [[1, 1, 0.5 - beta], [0, 1, 1 - gamma], [-alpha_f * w_h**2, 0, -alpha_m]]
    return float(np.abs(np.linalg.eigvals(np.linalg.solve(np.array(new), np.array(old)))).max())


def radau_theory(w_h: float) -> float:
    """Modulus of the stability function of Radau IIA, order 5, on the imaginary axis."""
    above, below = (sum(c * (1j * w_h) ** k for k, c in enumerate(part)) for part in RADAU)
    return float(abs(above / below))


def _bdf_rows() -> Iterator[Row]:
    for order in BDF_ORDERS:
        for w_h in np.geomspace(0.1, 20.0, 24):
            past = -w_h * np.arange(order - 1, 0, -1.0)
            made = new_integrator(
                "gear",
                _oscillator,
                0.0,
                np.array([1.0, 0.0]),
                400 * w_h,
                fixed_step=w_h,
                fixed_order=order,
                past=(past, np.column_stack((np.cos(past), -np.sin(past)))),
                rtol=1e-12,
                atol=1e-300,
            )
            yield Row(
                "bdf",
                "gear",
                order,
                w_h,
                _per_step(_seen(made, _amplitude)),
                bdf_theory(order, w_h),
            )


def _spring() -> Sample:
    """A unit mass on one mode of rate 1/s, its frame welded to the ground, displaced by 1 m."""
    phi, psi = np.zeros((1, 3, 1)), np.zeros((1, 3, 1))
    phi[0, 0, 0] = 1.0
    body = body_of(Points(np.ones(1), np.zeros((1, 3)), phi, psi, np.eye(3)[None]), 1.0)
    none = np.zeros((3, 1))
    markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3), np.eye(3), none, none)]
    model = assemble_model([body], markers, [JointTable("weld", "fixed", 0, 1)])
    positions, rest = np.zeros(8), np.zeros(7)
    positions[3] = positions[7] = 1.0
    return Sample(model, Start(positions, rest, np.ones(7, dtype=bool)), ["weld"], 1)


def _one_step_rows() -> Iterator[Row]:
    points = np.geomspace(0.1, 1000.0, 33)
    start = np.array([1.0, 0.0])
    for name, (kind, _) in EXPLICIT.items():
        for w_h in points[points < 30]:
            made = new_integrator(
                name, _oscillator, 0.0, start, 60 * w_h, fixed_step=w_h, rtol=1e-9
            )
            theory = explicit_theory(kind, 1j * w_h)
            yield Row("one-step", name, 0, w_h, _per_step(_seen(made, _amplitude)), theory)
    if "radau" in FOR_EQUATIONS:
        for w_h in points:
            made = new_integrator(
                "radau", _oscillator, 0.0, start, 60 * w_h, fixed_step=w_h, rtol=1e-9
            )
            measured = _per_step(_seen(made, _amplitude))
            yield Row("one-step", "radau", 0, w_h, measured, radau_theory(w_h))
    for rho in RADII:
        for w_h in points:
            treatment = Treatment("ggl")
            model, y0 = prepared(_spring(), treatment)
            t_end = (600 if rho > 0 else 200) * w_h
            options = {"spectral_radius": rho, "fixed_step": w_h, "rtol": 1e-10, "atol": 1e-300}
            made = new_run(model, y0, treatment, "generalized-alpha", t_end, **options)
            measured = _per_step(_seen(made, _of_mode))
            theory = alpha_theory(rho, w_h)
            yield Row("one-step", "generalized-alpha", rho, w_h, measured, theory)


def _feedback_rows() -> Iterator[Row]:
    """Largest opening of the joint of the pendulum A01 [m], alpha = beta."""
    for name, (_, limit) in EXPLICIT.items():
        for beta_h in np.geomspace(0.1, 10.0, 31):
            treatment = Treatment("baumgarte", alpha=beta_h / H, beta=beta_h / H)
            model, y0 = prepared(pendulum(), treatment)
            made = new_run(model, y0, treatment, name, T_END, fixed_step=H)
            opening = _seen(made, lambda i: abs(float(np.linalg.norm(i.y[:3])) - 1.0))
            yield Row("baumgarte", name, 0, beta_h, float(opening.max()), limit)


def _index_3_rows() -> Iterator[Row]:
    """Largest |Phidot| of the pendulum's last second over that of its first."""
    for formulation in ("index3", "ggl"):
        for rho in (0.0, 0.25, 0.5, 0.7, 0.8, 0.9, 0.94, 0.96, 0.97, 0.98, 0.99, 1.0):
            treatment = Treatment(formulation)
            model, y0 = prepared(pendulum(), treatment)
            made = new_run(
                model,
                y0,
                treatment,
                "generalized-alpha",
                T_END,
                spectral_radius=rho,
                fixed_step=H,
                rtol=1e-8,
                atol=1e-10,
            )

            def rate(i: Integrator, model: Any = model) -> float:
                equations = assemble(model, i.t, i.y)
                return float(np.abs(constraint_rates(model, equations, i.y)).max())

            values = _seen(made, rate)
            n = int(1.0 / H)
            yield Row(
                "index3",
                formulation,
                rho,
                made.t,
                float(values[-n:].max()),
                float(values[:n].max()),
            )


def measured() -> list[Row]:
    """All runs."""
    parts = (_bdf_rows(), _one_step_rows(), _feedback_rows(), _index_3_rows())
    return [row for part in parts for row in part]


def write(rows: list[Row], file: Path) -> None:
    """Rows as CSV."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(file) as temporary, temporary.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, [f.name for f in fields(Row)])
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def _growth_panel(axis: Any, rows: list[Row], theory: dict[str, Callable[[float], float]]) -> None:
    axis.axhspan(1.0, CAP, color=WARNING, alpha=0.05, linewidth=0)
    axis.axhline(1.0, color=INK, linewidth=0.8)
    for i, (label, line) in enumerate(theory.items()):
        mine = [row for row in rows if _label(row) == label]
        x = np.array([row.x for row in mine])
        dots = np.array([row.measured for row in mine])
        fine = np.geomspace(x.min(), x.max(), 400)
        axis.plot(fine, [line(v) for v in fine], color=colour(i), linewidth=1.2)
        axis.plot(x, dots, "o", color=colour(i), markersize=3.2, label=label)
    axis.set_xscale("log")
    axis.set_xlabel("$w\\,h$ [rad per step]")
    axis.set_ylabel("growth of an undamped mode per step")


def _label(row: Row) -> str:
    if row.method == "gear":
        return f"order {row.parameter:g}"
    if row.method == "generalized-alpha":
        return f"gen.-alpha {row.parameter:g}"
    return row.method


def draw(rows: list[Row], picture: Path) -> None:
    """Four panels."""
    of = {
        name: [r for r in rows if r.panel == name] for name in dict.fromkeys(r.panel for r in rows)
    }
    canvas = Canvas(11.0, 8.2)
    bdf, one_step, feedback, index_3 = canvas.panels(2, 2)

    _growth_panel(
        bdf,
        of["bdf"],
        {f"order {k}": lambda v, k=k: bdf_theory(k, v) for k in BDF_ORDERS},
    )
    bdf.set_ylim(0.0, 1.7)
    bdf.set_title("gear (BDF), fixed order: 3 and above grow")
    bdf.legend(loc="lower left", ncols=2)

    lines: dict[str, Callable[[float], float]] = {
        name: lambda v, kind=kind: explicit_theory(kind, 1j * v)
        for name, (kind, _) in EXPLICIT.items()
    }
    if any(row.method == "radau" for row in rows):
        lines["radau"] = radau_theory
    lines |= {f"gen.-alpha {rho:g}": lambda v, rho=rho: alpha_theory(rho, v) for rho in RADII}
    _growth_panel(one_step, of["one-step"], lines)
    one_step.set_ylim(0.0, 1.7)
    one_step.set_title("One-step methods: explicit ones have an end")
    one_step.legend(loc="upper right", ncols=2)

    for i, (name, (_, limit)) in enumerate(EXPLICIT.items()):
        mine = [row for row in of["baumgarte"] if row.method == name]
        opening = np.minimum([row.measured for row in mine], CAP)
        feedback.axvline(limit, color=colour(i), linestyle=(0, (3, 2)), linewidth=1.0)
        feedback.loglog([r.x for r in mine], opening, "o-", color=colour(i), ms=3.5, label=name)
    feedback.axhspan(1.0, CAP, color=WARNING, alpha=0.05, linewidth=0)
    feedback.axvline(2.0, color=INK, linewidth=0.8)
    feedback.set_ylim(1e-12, CAP * 2)
    feedback.set_xlabel("$\\beta\\,h$ ($\\alpha = \\beta$), h = 0.02 s")
    feedback.set_ylabel("largest opening of the joint in 4 s [m]")
    feedback.set_title("Baumgarte with fixed steps: holds to 2")
    handles, labels = feedback.get_legend_handles_labels()
    handles.append(Line2D([], [], color=INK, linestyle=(0, (3, 2)), linewidth=1.0))
    feedback.legend(handles, [*labels, "end of the real axis"], loc="upper left")

    for i, name in enumerate(("index3", "ggl")):
        mine = [row for row in of["index3"] if row.method == name]
        rho = [row.parameter for row in mine]
        index_3.semilogy(rho, [r.theory for r in mine], "s", color=colour(i), ms=5, mfc="none")
        index_3.semilogy(rho, [r.measured for r in mine], "o-", color=colour(i), ms=3.5, label=name)
        failed = [row for row in mine if row.x < T_END * (1 - 1e-9)]
        at = [row.parameter for row in failed], [row.measured for row in failed]
        index_3.semilogy(*at, "x", color=WARNING, ms=9, mew=1.6, zorder=4)
    index_3.set_xlabel("spectral radius at infinity")
    index_3.set_ylabel("largest $|\\dot\\Phi|$ in one second [m/s]")
    index_3.set_title("Generalized-alpha, pendulum, h = 0.02 s: index3 above 0.95")
    handles, labels = index_3.get_legend_handles_labels()
    handles.append(Line2D([], [], color=INK, marker="s", mfc="none", linestyle="", ms=5))
    handles.append(Line2D([], [], color=WARNING, marker="x", linestyle="", ms=9, mew=1.6))
    names = [f"{label}, last second" for label in labels]
    index_3.legend(handles, [*names, "first second", "the run fails"], loc="center left")
    picture.parent.mkdir(parents=True, exist_ok=True)
    canvas.save(picture, own=True)


def main() -> None:
    numbers, picture = map(Path, sys.argv[1:])
    rows = measured()
    write(rows, numbers)
    with house_style(formulas=True):
        draw(rows, picture)
    growth = [r for r in rows if r.panel in ("bdf", "one-step") and 1e-3 < r.theory < 1e3]
    worst = max(abs(r.measured / r.theory - 1) for r in growth)
    print(f"{numbers}, {picture}: {len(rows)} runs; measured growth within {worst:.1e} of theory")


if __name__ == "__main__":
    main()
