"""`[solver]` of a case file: time span, start, integrator, constraint treatment.

The names of integrators and the keys that only one of them has come from their classes.
"""

from typing import TYPE_CHECKING, Literal

from pydantic import create_model

from ....dynamics.elements.constraints.treatment import Treatment
from ....integrators.table import INTEGRATORS
from ...common.input_table import Axis, Table, Vector, entry, optional
from .laws import field_of

# Light crosses an atomic nucleus in 1e-23 s; squares of shorter times soon leave the floating point
# range, 1e-308.
SHORTEST = 1e-100  # [s]

if TYPE_CHECKING:
    IntegratorName = str
else:
    IntegratorName = Literal[(*INTEGRATORS,)]


class Spin(Table):
    """`spin` of `[solver]`: the whole mechanism turns about a fixed axis at constant speed."""

    axis: Axis = entry("direction of the axis, global", "-")
    point: Vector = entry("a point of the axis, global", "m", [0.0, 0.0, 0.0])
    speed: float = entry(
        'angular velocity about the axis; other than 0: with `start = "equilibrium"` only',
        "rad/s",
        0.0,
    )


class _Integration(Table):
    """Keys before those that one integrator has."""

    t_end: float = entry("end of the run", "s", ge=SHORTEST)
    output_step: float = entry("interval of the results", "s", ge=SHORTEST)
    most_outputs: int = entry(
        "outputs, t_end / output_step, that are not refused", default=10_000_000, ge=1
    )
    node_positions: Literal["auto", "all"] = entry(
        "positions of all drawn points in /results of result.vtkhdf: auto: at every output time "
        "if they need at most 100 MB, else left out, because they follow from the coordinates; "
        "all: always",
        default="auto",
    )
    start: Literal["positions", "quasi-static", "equilibrium"] = entry(
        "positions: as given, with joints closed; quasi-static: likewise, in the shapes that the "
        "loads of the motion at t = 0 call for; equilibrium: static equilibrium under all loads "
        "and drives at t = 0; with `spin`, relative equilibrium in axes that turn",
        default="positions",
    )
    spin: Spin | None = optional(
        "spin of the start in equilibrium; its axis is that of `plymotion modes --at spin=...` too"
    )
    modes_at_start: Literal["still", "free"] = entry(
        "modal rates at t = 0: still: zero, bodies start as if rigid; free: those of minimum "
        "kinetic energy, for a drive that starts at full speed",
        default="still",
    )
    integrator: IntegratorName = entry(
        "; ".join(f"{name}: {kind.meaning}" for name, kind in INTEGRATORS.items())
        + "; see integrators.md",
        default="radau",
    )
    rtol: float = entry(
        "accuracy: expected error of positions over the size of the mechanism, of velocities over"
        " its speed; see accuracy.md",
        default=1e-5,
        ge=1e-15,
        le=0.1,
    )
    error_bars: bool = entry(
        "state an error of each signal, from a second run with a coarser model "
        "(accuracy.md); also for the members of a sweep",
        default=False,
    )
    atol_position: float | None = optional(
        "absolute tolerance of positions and modal coordinates; default: rtol times their scales",
        gt=0,
    )
    atol_velocity: float | None = optional(
        "absolute tolerance of velocities and modal rates; default: rtol times their scales", gt=0
    )
    max_step: float | None = optional(
        "largest step; default: t_end / 200 where an expression reads the time, t_end / 2000 with"
        " a table that has more than 2000 kinks; else none; steps also end where laws of time "
        "break",
        "s",
        gt=0,
    )


if TYPE_CHECKING:
    _WithOptions = _Integration
else:
    _WithOptions = create_model(
        "_WithOptions",
        __base__=_Integration,
        **{key.name: field_of(key) for kind in INTEGRATORS.values() for key in kind.keys},
    )


class Solver(_WithOptions):
    """`[solver]`: time span, start, integrator, constraint treatment."""

    constraints: Literal[
        "index1", "baumgarte", "augmented-lagrangian", "projection", "ggl", "index3"
    ] = entry("treatment of the joints' equations, see constraints.md", default="projection")
    alpha: float = entry("Baumgarte's velocity feedback", "1/s", Treatment.alpha, ge=0)
    beta: float = entry("Baumgarte's position feedback", "1/s", Treatment.beta, ge=0)
    penalty: float = entry(
        "augmented Lagrangian: relative to the effective mass of a constraint",
        default=Treatment.penalty,
        gt=0,
    )
    frequency: float = entry(
        "augmented Lagrangian: frequency of the feedback", "1/s", Treatment.frequency, ge=0
    )
    ratio: float = entry("augmented Lagrangian: its damping ratio", default=Treatment.ratio, ge=0)
    attachment: Literal["marker", "virtual"] = entry(
        "joints at flexible bodies: through the interface's own motion, or through a massless "
        "virtual body fixed to it by six constraints (the paper)",
        default="marker",
    )
    on_singular: Literal["stop", "warn"] = entry(
        "when a treatment of the constraints fails in a singular position: end the run there, or "
        "continue",
        default="stop",
    )
    on_invalid: Literal["stop", "warn"] = entry(
        "when a linear body stops being valid, or a stiffened one buckles: end the run there, or "
        "continue",
        default="stop",
    )
    geometric_stiffening: bool = entry(
        "second-order displacements of flexible bodies, for fast spin or large bending: "
        "stiffening.md; a body whose package has none stays linear, with a warning",
        default=False,
    )
