"""`[solver]` of a case file: time span, start, integrator, constraint treatment.

The names of integrators and the keys that only one of them has come from their classes.
"""

from typing import TYPE_CHECKING, Literal

from pydantic import Field, create_model

from ....dynamics.elements.constraints.treatment import Treatment
from ....integrators.table import INTEGRATORS
from ...common.table import Axis, Table, Vector, unit
from .kinds import field_of

# Light crosses an atomic nucleus in 1e-23 s; squares of shorter times soon leave the floating point
# range, 1e-308.
SHORTEST = 1e-100  # [s]

if TYPE_CHECKING:
    IntegratorName = str
else:
    IntegratorName = Literal[(*INTEGRATORS,)]


class Spin(Table):
    """`spin` of `[solver]`: the whole mechanism turns about a fixed axis at constant speed."""

    axis: Axis = Field(description="direction of the axis, global", json_schema_extra=unit("-"))
    point: Vector = Field(
        default=[0.0, 0.0, 0.0],
        description="a point of the axis, global",
        json_schema_extra=unit("m"),
    )
    speed: float = Field(
        default=0.0,
        description="angular velocity about the axis; other than 0: with `start = "
        '"equilibrium"` only',
        json_schema_extra=unit("rad/s"),
    )


class _Integration(Table):
    """Keys before those that one integrator has."""

    t_end: float = Field(ge=SHORTEST, description="end of the run", json_schema_extra=unit("s"))
    output_step: float = Field(
        ge=SHORTEST, description="interval of the results", json_schema_extra=unit("s")
    )
    most_outputs: int = Field(
        default=10_000_000, ge=1, description="outputs, t_end / output_step, that are not refused"
    )
    node_positions: Literal["auto", "all"] = Field(
        default="auto",
        description="positions of all drawn points in /results of result.vtkhdf: auto: at every "
        "output time if they need at most 100 MB, else left out, because they follow from the "
        "coordinates; all: always",
    )
    start: Literal["positions", "quasi-static", "equilibrium"] = Field(
        default="positions",
        description="positions: as given, with joints closed; quasi-static: likewise, in the "
        "shapes that the loads of the motion at t = 0 call for; equilibrium: static equilibrium "
        "under all loads and drives at t = 0; with `spin`, relative equilibrium in axes that turn",
    )
    spin: Spin | None = Field(
        default=None,
        description="spin of the start in equilibrium; its axis is that of `plymotion modes --at "
        "spin=...` too",
    )
    modes_at_start: Literal["still", "free"] = Field(
        default="still",
        description="modal rates at t = 0: still: zero, bodies start as if rigid; free: those "
        "of minimum kinetic energy, for a drive that starts at full speed",
    )
    integrator: IntegratorName = Field(
        default="radau",
        description="; ".join(f"{name}: {kind.meaning}" for name, kind in INTEGRATORS.items())
        + "; see integrators.md",
    )
    rtol: float = Field(
        default=1e-5,
        ge=1e-15,
        le=0.1,
        description="accuracy: expected error of positions over the size of the mechanism, of "
        "velocities over its speed; see accuracy.md",
    )
    atol_position: float | None = Field(
        default=None,
        gt=0,
        description="absolute tolerance of positions and modal coordinates; default: rtol times "
        "their scales",
    )
    atol_velocity: float | None = Field(
        default=None,
        gt=0,
        description="absolute tolerance of velocities and modal rates; default: rtol times their "
        "scales",
    )
    max_step: float | None = Field(
        default=None,
        gt=0,
        description="largest step; default: t_end / 200 where an expression reads the time, "
        "t_end / 2000 with a table that has more than 2000 kinks; else none; steps also end where "
        "laws of time break",
        json_schema_extra=unit("s"),
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
    ] = Field(
        default="projection",
        description="treatment of the joints' equations, see constraints.md",
    )
    alpha: float = Field(
        default=Treatment.alpha,
        ge=0,
        description="Baumgarte's velocity feedback",
        json_schema_extra=unit("1/s"),
    )
    beta: float = Field(
        default=Treatment.beta,
        ge=0,
        description="Baumgarte's position feedback",
        json_schema_extra=unit("1/s"),
    )
    penalty: float = Field(
        default=Treatment.penalty,
        gt=0,
        description="augmented Lagrangian: relative to the effective mass of a constraint",
    )
    frequency: float = Field(
        default=Treatment.frequency,
        ge=0,
        description="augmented Lagrangian: frequency of the feedback",
        json_schema_extra=unit("1/s"),
    )
    ratio: float = Field(
        default=Treatment.ratio, ge=0, description="augmented Lagrangian: its damping ratio"
    )
    attachment: Literal["marker", "virtual"] = Field(
        default="marker",
        description="joints at flexible bodies: through the interface's own motion, or through a "
        "massless virtual body fixed to it by six constraints (the paper)",
    )
    on_singular: Literal["stop", "warn"] = Field(
        default="stop",
        description="when a treatment of the constraints fails in a singular position: end the "
        "run there, or continue",
    )
    on_invalid: Literal["stop", "warn"] = Field(
        default="stop",
        description="when a linear body stops being valid, or a stiffened one buckles: end the run "
        "there, or continue",
    )
    geometric_stiffening: bool = Field(
        default=False,
        description="second-order displacements of flexible bodies, for fast spin or large "
        "bending: stiffening.md; a body whose package has none stays linear, with a warning",
    )
