"""A mechanism that moves from one communication point to the next, with inputs in between."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...dynamics.model.model import Model
from ...errors import InputError
from ...integrators.choice import make_integrator
from ...integrators.generic import Integrator
from ...integrators.table import INTEGRATORS
from ...math.arrays import Array
from ...signals import recorded
from ..outcome import RunSpec
from ..preparation import Prepared, prepare
from .course import Course
from .inputs import Input, inputs_of, shift_law, write_piece

DRIVE_ORDER, FORCE_ORDER = 2, 1


class Stepper:
    """A run under way in the hands of another program.

    Steps of the integrator end at every communication point, and it goes on from there as from a
    start. Outputs are those at the end of the step.

    Parameters
    ----------
    spec : the run; its laws of inputs are of use for the start and for the tolerances only
    inputs : names of those that are written from outside; None: all. The others follow the case

    Raises
    ------
    InputError
        An unknown input; an integrator that cannot restart at communication points.
    """

    t: float  # [s]
    y: Array  # (n,) state
    _started: bool  # the prepared mechanism has been started from
    _integrator: Integrator | None  # from the first step on

    def __init__(self, spec: RunSpec, inputs: Sequence[str] | None = None) -> None:
        self._spec = spec
        _require_restarts(spec)
        self._begin(prepare(spec.mechanism, spec.packages))
        self._started = False
        known = {found.name: found for found in inputs_of(spec.mechanism, self._prepared.built)}
        for name in inputs or ():
            if name not in known:
                raise InputError(f"{name}: no such input; expected some of {', '.join(known)}")
        self.inputs: list[Input] = [
            found for name, found in known.items() if inputs is None or name in inputs
        ]
        # One that looks at a whole run before it has values cannot be an output.
        looking = [n for n, sensor in self._prepared.measured.items() if sensor.look is not None]
        self.left_out = tuple(looking)
        self.outputs = {
            name: sensor for name, sensor in self._prepared.measured.items() if name not in looking
        }

    def start(
        self,
        values: Array | None = None,
        *,
        drive_order: int = DRIVE_ORDER,
        force_order: int = FORCE_ORDER,
    ) -> Array:
        """Close the joints with these inputs (k,) at t = 0; return the outputs (n,).

        values : None: those of the case
        drive_order, force_order : 0, 1 or 2, of the polynomials between communication points

        Raises
        ------
        InputError
            A mechanism that cannot be assembled.
        """
        own = np.array([given.start[0] for given in self.inputs])
        change = np.zeros(len(own)) if values is None else values - own

        def adjust(model: Model) -> None:
            for given, by in zip(self.inputs, change, strict=True):
                if by:
                    shift_law(model, given.law, float(by))

        if change.any() or self._started:  # otherwise prepared when it was made
            self._begin(prepare(self._spec.mechanism, self._spec.packages, adjust=adjust))
        self._started = True
        self._courses = [
            Course(
                given.start + np.array([by, 0.0, 0.0]),
                drive=given.drive,
                order=drive_order if given.drive else force_order,
            )
            for given, by in zip(self.inputs, change, strict=True)
        ]
        return self._measured()

    def advance(self, t: float, values: Array, rates: Array | None = None) -> Array:
        """Move on to t [s] and return the outputs there, (n,).

        Parameters
        ----------
        values : (k,) inputs at the present time
        rates : (k, 2) their first and second derivatives; nan, or None: unknown

        Raises
        ------
        InputError
            The run cannot go on; the message says why. `t` and `y` are those of its last step.
        """
        if self._integrator is None:
            prepared = self._prepared
            if prepared.refused is not None:
                raise InputError(prepared.refused.message)
            self._integrator = make_integrator(
                prepared.model, prepared.y0, prepared.mechanism.solver, prepared.treatment
            )
        h, known = t - self.t, np.full((len(values), 2), np.nan) if rates is None else rates
        for given, course, value, its in zip(
            self.inputs, self._courses, values, known, strict=True
        ):
            piece = course.piece(self.t, h, float(value), its)
            piece[0] += given.offset
            write_piece(self._prepared.model, given.law, self.t, piece)
        self._move(self._integrator, t)
        return self._measured()

    def warnings(self) -> list[str]:
        """Return what the monitors have found since the last call."""
        prepared = self._prepared
        found = [*prepared.notes, *prepared.spin.findings, *prepared.passage.findings]
        found += prepared.buckling.findings if prepared.buckling is not None else []
        texts = [f"[{finding.code}] {finding.text}" for finding in found]
        fresh = [text for text in texts if text not in self._told]
        self._told.update(fresh)
        return fresh

    def _begin(self, prepared: Prepared) -> None:
        self._prepared, self._watch = prepared, prepared.watch
        self._integrator = None
        self.t, self.y = 0.0, prepared.y0
        self._memory: dict[Any, Any] = {}
        self._told: set[str] = set()

    def _move(self, integrator: Any, t: float) -> None:
        integrator.go_on(t)
        nowhere = np.empty(0), np.empty((0, integrator.n))
        while integrator.status == "running":
            integrator.stride(*nowhere, 0, True)
            request = self._watch(integrator.steps_taken())
            integrator.take_up()
            self.t, self.y = integrator.t, integrator.y
            if request is not None:
                raise InputError(request.message)
        if integrator.status != "finished":
            raise InputError(integrator.message)

    def _measured(self) -> Array:
        """Return the outputs at the present time, (n,)."""
        block = np.array([self.t]), self.y[None]
        _, found = next(recorded(self.outputs, self._prepared.model, lambda: [block], self._memory))
        return np.array([values[0] for _, values in found])


def _require_restarts(spec: RunSpec) -> None:
    """Raise InputError for integrators that need what was before a communication point."""
    name = spec.mechanism.solver.integrator
    if not INTEGRATORS[name].samples:
        able = [f'"{other}"' for other, kind in INTEGRATORS.items() if kind.samples]
        raise InputError(
            f'solver.integrator = "{name}": goes on from earlier steps, which inputs that change '
            f"at communication points do not allow; expected {' or '.join(able)}"
        )
