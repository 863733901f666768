"""Exact derivatives of a design: by those that its packages carry, not by other packages.

The specification of a body names the numbers that a parameter sets, and their derivatives, which
are found by comparing specifications beside the design. So it does not matter how a ply is written
in the case. The preprocessor adds derivatives of all arrays to the package (`/design`,
docs/format.md). A run beside the design is then one with packages moved along them, and its motion
that of the design moved along the tangent.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...checks.finished_run import FinishedRun
from ...dynamics.evaluation.instants import Instants
from ...errors import InputError
from ...inputs.case.bodies.specifications import BodySpec
from ...inputs.case.tables.schema import Mechanism
from ...inputs.section.study import leaves_of
from ...math.arrays import Array
from ...mechanism.build import used_packages
from ...package.common.plain_data import inputs_sha256
from ...run.inputs import RunSpec
from ...run.preparation import Prepared, output_times
from ...signals import HELD, Recording
from ..sensitivities.adjoint import Adjoint
from ..sensitivities.differentiated_run import (
    Followed,
    Trace,
    bends_of,
    beside_motion,
    change_of,
    cuts_of,
    followed,
    of_steps,
    sensors_beside,
    sides,
)
from ..sensitivities.parameters import Parameter, Variant
from .measures import Made, Measure

STEP = 1e-4  # of the range of a parameter, along derivatives and between specifications
TRIED, LEAST = 1e-5, 1e-4  # of the largest motion of a coordinate, and of the mechanism's size
# Of a mechanism in some motion: arrays (..., n_t) at the output times.
Read = Callable[[Variant, Recording], Sequence[Array]]
Weights = Sequence[tuple[Array, str]]  # (v, ..., n_t) of each array in v numbers; its unit
Specs = Mapping[str, BodySpec]


def beside(p: Array, steps: Array, ranges: Array | None = None) -> list[Array]:
    """Return a design and those less and plus a step of each parameter: 1 + 2 p of them.

    Parameters
    ----------
    p : (p,) values of the parameters
    steps : (p,) of the parameters
    ranges : (p, 2) bounds. Where a step would pass one, both designs of this parameter are moved
        inwards: a case may not have an angle beyond 90 degrees.
    """
    moved = np.zeros(p.size)
    if ranges is not None:
        moved = np.clip(p, ranges[:, 0] + steps, ranges[:, 1] - steps) - p
    return [p, *(p + (m + s * h) * e for m, h, e in zip(moved, steps, np.eye(p.size), strict=True)
                 for s in (-1, 1))]  # fmt: skip


def with_targets(
    names: Sequence[str], specs: Sequence[Specs], steps: Array, without: Sequence[str] = ()
) -> dict[str, BodySpec]:
    """Return specifications of bodies that ask for derivatives.

    Parameters
    ----------
    names : of the parameters
    specs : of the designs of `beside`
    without : derivatives of beams that nothing depends on, as in `BeamSpecification`

    Raises
    ------
    InputError
        A parameter that changes more than numbers: another mesh, another count of elements.
    """
    specs_by_body = dict(specs[0])
    for body, spec in specs[0].items():
        design = {}
        for k, name in enumerate(names):
            minus, plus = specs[1 + 2 * k][body], specs[2 + 2 * k][body]
            if plus.inputs_sha256 != minus.inputs_sha256:
                where = f"parameter {name}, body {body}"
                at = minus.content, spec.content, plus.content
                design[name] = list(_targets(where, at, 2.0 * steps[k]))
        if design:
            content: Any = {**spec.content, "design": design}
            if without and content["kind"] == "beam":
                content["design_without"] = list(without)
            specs_by_body[body] = replace(
                spec, content=content, inputs_sha256=inputs_sha256(content)
            )
    return specs_by_body


def _targets(where: str, at: tuple[Any, Any, Any], h: float) -> Iterator[dict[str, object]]:
    """Yield the paths of numbers that differ below and above a design, with their derivatives.

    The design itself, the second of three, counts, too: where two plies have one thickness, a mesh
    may have fewer cells than on both sides.
    """
    low, own, high = map(leaves_of, at)
    if not low.keys() == own.keys() == high.keys():
        raise InputError(f"{where}: changes the model, not only its numbers")
    for path, value in low.items():
        other = high[path]
        if not all(isinstance(each, float) for each in (value, own[path], other)):
            if not value == own[path] == other:
                name = ".".join(map(str, path))
                raise InputError(f"{where}: changes {name} from {value!r} to {other!r}")
            continue
        if value == other:
            continue
        yield {"of": list(map(str, path)), "factor": float(f"{(other - value) / h:.10g}")}


def runs_beside(
    spec: RunSpec,
    names: Sequence[str],
    steps: Array,
    mechanisms: Sequence[tuple[Mechanism, Mechanism]] | None = None,
    without: Sequence[str] = (),
) -> list[Parameter]:
    """Return parameters with the runs less and plus a step of each, by derivatives of packages.

    Parameters
    ----------
    mechanisms : less and plus the step of each parameter; None: that of the run
    without : as of `with_targets`. Where packages have no derivatives of stresses or terms of
        second order, these runs have neither, so that nothing is taken for what does not change
    """
    packages = dict(spec.packages)
    for name, p in packages.items():
        if "stresses" in without:
            p = replace(p, sections=tuple(replace(s, recovery=None) for s in p.sections))
        packages[name] = replace(p, second_order=None) if "second_order" in without else p
    spec = replace(spec, packages=packages)
    sides = mechanisms or [(spec.mechanism, spec.mechanism)] * len(names)
    return [
        Parameter(
            name, "", 0.0, h,
            replace(spec.moved(name, -h), mechanism=minus),
            replace(spec.moved(name, h), mechanism=plus),
        )
        for name, h, (minus, plus) in zip(names, steps.tolist(), sides, strict=True)
    ]  # fmt: skip


@dataclass(frozen=True)
class Traced:
    """A run of a design with its trace: the run itself, or one that its signals read.

    Attributes
    ----------
    signals : that are read of it
    """

    prepared: Prepared
    finished: FinishedRun
    trace: Trace
    signals: Collection[str]

    def followed(self, parameters: Sequence[Parameter], held: dict[str, object]) -> Followed:
        """Return it with its tangent; `held`: points of plies that govern in it."""
        y = np.asarray(self.finished.solution.y[:])
        return followed(self.prepared, parameters, self.trace.steps, y, held)

    def still(self, parameters: Sequence[Parameter], held: dict[str, object]) -> Followed:
        """Return it as if with its tangent by parameters that do not change its motion."""
        prepared, solution = self.prepared, self.finished.solution

        def variant(spec: RunSpec) -> Variant:
            packages = used_packages(prepared.mechanism, spec.packages)
            return Variant(replace(prepared.built, packages=packages), prepared.y0)

        pairs = [(variant(p.minus), variant(p.plus)) for p in parameters]
        size = 2 * prepared.model.n_vel + prepared.model.n_aux
        S = np.zeros((len(solution.t), size, len(parameters)))
        y = np.asarray(solution.y[:])
        return Followed(prepared, parameters, solution.t, y, S, pairs, held)


def made_beside(
    own: str, traced: Mapping[str, Traced], motions: Mapping[str, Followed], k: int, of: Parameter
) -> Iterator[Made]:
    """Yield the designs less and plus the step of parameter k, by the tangents of their runs.

    Parameters
    ----------
    own : name of the run; those that its signals read have others
    of : the parameter of the run itself
    """
    pair = of.minus, of.plus
    if own not in traced:
        yield from (Made(spec, None, {}, None) for spec in pair)
        return
    histories: list[dict[str, tuple[Array, dict[str, Array]]]] = [{}, {}]
    for run, motion in motions.items():
        if run == own:
            continue
        for history, (each, recording) in zip(histories, motion.beside(k), strict=True):
            read = sensors_beside(motion.prepared, each, recording, traced[run].signals)
            history[run] = recording.t, {n: s.values(recording) for n, s in read.items()}
    one, motion = traced[own], motions[own]
    for spec, (each, recording), known in zip(pair, motion.beside(k), histories, strict=True):
        read = sensors_beside(motion.prepared, each, recording, one.signals, known)
        yield Made(spec, replace(one.finished, built=each.built), read, recording)


def gradients(
    traced: Traced, parameters: Sequence[Parameter], read: Read, weights: Weights
) -> Array:
    """Return the derivatives (P, v) of v numbers of a run by its parameters.

    Parameters
    ----------
    traced : the run with its trace
    parameters : numbers of its case
    read : what the numbers are made of, each value by the state at its own time
    weights : derivatives of the numbers by what `read` returns, at the run itself

    Raises
    ------
    InputError
        As `sides`; a run with impacts or sampled states, which have no adjoint.
    """
    prepared, steps = traced.prepared, traced.trace.steps
    model, solver = prepared.model, prepared.mechanism.solver
    if model.quantities.event_state.size or Instants(model, solver.t_end).t.size:
        raise InputError(
            "the adjoint of runs with impacts or sampled states is not implemented; expected the "
            "tangent, without an objective"
        )
    pairs, columns, start = sides(prepared, parameters)
    times, held = output_times(solver.t_end, solver.output_step), dict[str, object]()
    y = np.asarray(traced.finished.solution.y[:])
    itself = Variant(replace(prepared.built, model=model), prepared.y0)
    read(itself, Recording(model, times, y, {HELD: held}))  # notes which plies govern

    def change(S: Array, h: float, pair: tuple[Variant, Variant]) -> Array:
        """Derivatives (n_t, v) of the summands of the numbers along S and between mechanisms."""
        beside = beside_motion(prepared, times, y, S, h, pair, held)
        rows = (read(each, recording) for each, recording in beside)
        return np.asarray(
            sum(
                np.einsum(
                    "vst,st->tv",
                    w.reshape(len(w), -1, times.size),
                    change_of(low, high, unit).reshape(-1, times.size) / (2.0 * h),
                )
                for low, high, (w, unit) in zip(*rows, weights, strict=True)
            )
        )

    adjoint = Adjoint(
        model, columns, prepared.y0, len(weights[0][0]), bends_of(prepared), cuts_of(prepared)
    )
    spans = _spans(prepared, times, y, adjoint.units)
    by_state = np.stack(
        [
            change(row, TRIED * span, (itself, itself))
            for row, span in zip(np.eye(spans.size), spans, strict=True)
        ],
        axis=1,
    )
    untils = [times[0], *(each.t[-1] for each in steps)]
    for until, each in zip(untils[-2::-1], reversed(steps), strict=True):
        own, within = of_steps(times, float(until), each.t)
        adjoint.back(each, within, by_state[own])
    direct = [
        change(np.zeros(spans.size), parameter.h, pair).sum(axis=0)
        for parameter, pair in zip(parameters, pairs, strict=True)
    ]
    return np.asarray(adjoint.gradient + start.T @ (adjoint.S + by_state[0]) + np.array(direct))


def _spans(prepared: Prepared, t: Array, y: Array, units: Array) -> Array:
    """Return the sizes (2 n_vel + n_aux,) of the motion of all coordinates and their rates.

    Modes by their own motion: stresses are not linear over a larger one.
    """
    model, size = prepared.model, 1.0 / units
    for a, j, m in zip(model.pos_start, model.vel_start, model.n_mode, strict=True):
        modes = slice(j + 6, j + 6 + m)
        moved = np.abs(y[:, a + 7 : a + 7 + m]).max(axis=0)
        size[modes] = np.maximum(moved, LEAST * size[modes])
    rest = np.abs(y[:, model.n_pos : -1]).max(axis=0)
    least = LEAST * np.concatenate([size / t[-1], np.ones(model.n_aux)])
    return np.concatenate([size, np.maximum(rest, least)])


def by_adjoint(
    traced: Traced, parameters: Sequence[Parameter], measures: Sequence[Measure], made: Made
) -> list[Array]:
    """Return derivatives (r, P) of the r values of each measure of one run.

    Parameters
    ----------
    traced : the run with its steps
    parameters : the P parameters, with the runs beside
    measures : of this run
    made : the same run with its recording

    Raises
    ------
    InputError
        As `gradients`.
    """
    raws = [m.raw(made) for m in measures]
    own = [m.reduce(raw, made.t)[1] for m, raw in zip(measures, raws, strict=True)]
    ends = np.cumsum([len(w) for w in own])
    weights: Weights = [
        (np.pad(w, [(end - len(w), ends[-1] - end), *[(0, 0)] * (w.ndim - 1)]), m.unit)
        for w, end, m in zip(own, ends.tolist(), measures, strict=True)
    ]

    def read(each: Variant, recording: Recording) -> list[Array]:
        sensors = sensors_beside(traced.prepared, each, recording, traced.signals)
        finished = replace(traced.finished, built=each.built)
        there = Made(made.spec, finished, sensors, recording)
        return [m.raw(there, w) for m, w in zip(measures, own, strict=True)]

    return np.split(gradients(traced, parameters, read, weights).T, ends[:-1])


def adjoint_slopes(
    traced: Mapping[str, Traced],
    parameters: Sequence[Parameter],
    measures: Sequence[Measure],
    made: Made,
) -> list[Array] | None:
    """Return slopes (r, P) by measure; None where the adjoint does not serve.

    Signals that read another run, and what `gradients` refuses, are left to the tangent.

    Parameters
    ----------
    traced : run of the design by name, and those that its signals read
    parameters : the P parameters, with the runs beside
    measures : of the study, of runs or of packages alone
    made : the design
    """
    if list(traced) != [made.spec.run]:
        return None
    try:
        of_run = [m for m in measures if m.runs]
        slopes_of_run = iter(by_adjoint(traced[made.spec.run], parameters, of_run, made))
    except InputError:
        return None
    slopes = []
    for m in measures:
        if m.runs:
            slopes.append(next(slopes_of_run))
            continue
        beside = [
            [m.raw(Made(run, None, {}, None)) for run in (p.minus, p.plus)] for p in parameters
        ]
        rates = [(b - a) / (2.0 * p.h) for (a, b), p in zip(beside, parameters, strict=True)]
        w = m.reduce(m.raw(made), made.t)[1]
        slopes.append(np.tensordot(w, np.stack(rates, axis=-1), axes=w.ndim - 1))
    return slopes
