"""Designs of a study: built and run as members of a sweep are, with packages of their own."""

import logging
import os
from collections.abc import Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plymotion import __version__

from ...checks.finished_run import FinishedRun, Look
from ...checks.judge import checked
from ...errors import InputError, PackageError, few
from ...inputs.case.bodies.segments import in_segments
from ...inputs.case.bodies.specifications import BodySpec, model_and_check
from ...inputs.case.design import CheckedStudy
from ...inputs.case.load import checked_case
from ...inputs.case.messages import ERRORS
from ...inputs.case.record import needed, solver_sha256, with_parts
from ...inputs.case.sweeps import Members
from ...inputs.case.tables.bodies import PackageBody
from ...inputs.case.tables.design_keys import Quantity
from ...inputs.case.tables.schema import Mechanism, changed_mechanism
from ...inputs.case.tables.signals import PlyStressSignal, StrengthSignal
from ...inputs.case.write import dump
from ...math.arrays import Array
from ...package import ModalPackage, read_package
from ...package.common.files import write_text
from ...package.common.object_file import PACKED, unpacked
from ...package.common.plain_data import data_sha256
from ...package.specification import fingerprint
from ...run.inputs import RunSpec
from ...run.preparation import Prepared, histories_of, integrated, prepare
from ...signals import HELD, Recording
from ...workers.executors import Local
from ...workers.launch import keep_preprocessors
from ...workers.packages import BodiesFailed, build_packages
from ..sensitivities.differentiated_run import Followed, Trace, change_of
from ..sensitivities.parameters import Parameter, combined, parted
from .exact import (
    STEP,
    Traced,
    adjoint_slopes,
    beside,
    made_beside,
    runs_beside,
    with_targets,
)
from .measures import Made, Measure, measure_of
from .problem import Values

LOGGER = logging.getLogger(__name__)
LOOK = Look(balance=101, momentum=3, stiffening=41)  # as in a sweep
MANY = 100  # parameters, above which runs have derivatives by their adjoint
BODIES = "bodies"  # folder of packages, a folder for each process
STATE = 2  # version of what is kept of a design: raised when its numbers change their meaning


@dataclass(frozen=True)
class StudySpec:
    """What a process needs to compute designs of a study; it can be pickled."""

    table: dict[str, object]  # the case as the user wrote it
    file: Path  # of the case
    coarse: bool
    study: str
    folder: Path  # of the study, for packages and state
    plan: Any = None  # of a run with [fidelity], frozen (planning.py)
    exact: bool = False  # derivatives by those of packages


class Trials:
    """The designs of a study in this process."""

    def __init__(self, given: StudySpec) -> None:
        case = checked_case(given.table, given.file, coarse=given.coarse, sweeps=())
        self.given, self.case = given, case.name
        self.study: CheckedStudy = case.studies[given.study]
        self.measures: list[Measure] = [measure_of(q) for q in self.study.table.quantities()]
        self.runs = any(m.runs for m in self.measures)
        self._plan, self.exact = given.plan, given.exact
        # Of the last design: parameters (r) by run that move packages and mechanism in all ways;
        # shares (r, p) of these in all parameters; numbers of those that move stresses besides, and
        # these by run; measures that read stresses.
        self._beside: dict[str, list[Parameter]] = {}
        self._shares = np.zeros((0, 0))
        self._moving: list[int] = []
        self._stresses: dict[str, list[Parameter]] = {}
        self._stressed: list[Measure] = []
        self._failed: dict[Path, str] = {}  # packages that could not be built
        self._refused = ""  # why the packages of the last design have no derivatives
        # Its arrays, and derivatives (r, ...) of its values by them, by measure.
        self._last: tuple[bytes, Made, list[Array], list[Array]] | None = None
        self._traces: dict[str, Traced] = {}  # of the last design, by run
        keep_preprocessors()

    def digest(self) -> str:
        """Return the hash of all that the numbers of a design depend on."""
        study = self.study
        designs = study.designs([study.start])
        bodies = [*designs.own.bodies, *(b for m in designs.others.values() for b in m.bodies)]
        fingerprints = [fingerprint(dict(s.content)) for each in bodies for s in each.values()]
        others = [members.base.model_dump() for members in designs.others.values()]
        targets = {n: [t.model_dump() for t in ts] for n, ts in study.targets.items()}
        own: list[Any] = [study.merged, study.table.model_dump(), targets, others, fingerprints]
        own += [p.model_dump() for p in study.parameters.values()]
        own += [self._plan.table() if self._plan is not None else None, self.given.exact]
        return data_sha256([STATE, __version__, solver_sha256(), *own])

    # Values and slopes of designs.

    def values(self, p: Array) -> Values:
        """Return the values of a design (p,), or why it is invalid."""
        self._refused = ""
        made = self._made_exact(p) if self.exact else self._made([p])[0]
        if self._refused:
            made = self._made([p])[0]
        if isinstance(made, str):
            return Values(made, [], [], [])
        try:
            raws = [measure.raw(made) for measure in self.measures]
            reduced = [m.reduce(raw, made.t) for m, raw in zip(self.measures, raws, strict=True)]
            shown = [m.shown(raw, made.t) for m, raw in zip(self.measures, raws, strict=True)]
        except (InputError, *ERRORS) as error:
            return Values(_line(error), [], [], [])
        self._last = p.tobytes(), made, raws, [weights for _, weights in reduced]
        measured = [values.tolist() for values, _ in reduced]
        return Values("", measured, shown, [m.unit for m in self.measures])

    def slopes(self, p: Array) -> list[list[list[float]]]:
        """Return the derivatives of the values of a valid design: by measure, value, parameter."""
        if self._last is None or self._last[0] != p.tobytes():
            why = self.values(p).why
            if why:
                raise InputError(why)
        assert self._last is not None
        _, made, _, weights = self._last
        if self.exact and p.size > MANY and not self._refused:
            parameters = self._beside[self.study.table.run]
            by_adjoint_method = adjoint_slopes(self._traces, parameters, self.measures, made)
            if by_adjoint_method is not None:
                return [
                    (each @ self._shares + _contracted(w, own)).tolist()
                    for each, w, own in zip(
                        by_adjoint_method, weights, self._direct(self._held()), strict=True
                    )
                ]
        columns = zip(*self._columns(p), strict=True)
        return [
            _contracted(w, np.array(own)).tolist() for w, own in zip(weights, columns, strict=True)
        ]

    def _columns(self, p: Array) -> list[list[Array]]:
        """Return the derivatives of the arrays of all measures, by parameter."""
        if not self.exact:
            return self._differences(p)
        try:
            return self._exact()
        except InputError as error:  # such as an impact that has no derivative
            if self.study.table.gradient == "exact":
                raise
            LOGGER.warning(
                "%s: derivatives of one design by differences: %s", self.study.name, _line(error)
            )
            return self._differences(p)

    def words_of_gradient(self) -> str:
        """Return how derivatives are computed, and how exact they are."""
        if self.exact:
            run = ", and the tangent of the run" if self.runs else ""
            return f"exact: by the derivatives that packages carry{run}"
        steps = ", ".join(
            f"{name} {h:.3g}" for name, h in zip(self.study.parameters, self.steps(), strict=True)
        )
        return (
            f"central differences of designs that are built anew, steps {steps}; runs at rtol "
            f"{self.study.table.rtol:g}: noise of about {self.study.table.rtol:g} of a signal "
            "over two steps"
        )

    def richer(self) -> "Trials":
        """Return trials of finer bodies, without a plan."""
        copied = copy(self)
        copied.study, copied._plan, copied._last = self.study.richer(), None, None
        copied.exact = False
        return copied

    def steps(self, share: float | None = None) -> Array:
        """Return the steps of differences (p,), or a share of the range of each parameter."""
        share = self.study.table.difference if share is None else share
        ranges = [p.range() for p in self.study.parameters.values()]
        return np.array([share * (high - low) for low, high in ranges])

    def _differences(self, p: Array) -> list[list[Array]]:
        """Return central differences of the arrays of all measures, by parameter.

        A design beside p whose run is invalid is replaced by p itself: a one-sided difference.
        """
        assert self._last is not None
        own, steps = self._last[2], self.steps()
        pairs: list[tuple[float, list[Array]]] = []
        made_beside = self._made(beside(p, steps)[1:])
        for sign, made in zip([-1.0, 1.0] * p.size, made_beside, strict=True):
            raws = None if isinstance(made, str) else [m.raw(made) for m in self.measures]
            same = raws is not None and all(
                a.shape == b.shape for a, b in zip(raws, own, strict=True)
            )
            pairs.append((sign, raws) if same and raws is not None else (0.0, own))
        columns = []
        for k, h in enumerate(steps):
            (down, low), (up, high) = pairs[2 * k : 2 * k + 2]
            if up == down:
                raise InputError("no design beside this one can be run: its derivative is unknown")
            columns.append([(a - b) / (h * (up - down)) for a, b in zip(high, low, strict=True)])
        return columns

    def _exact(self) -> list[list[Array]]:
        """Return derivatives of the arrays of all measures, by parameter."""
        if self._refused:
            raise InputError(self._refused)
        held = self._held()
        motions = {
            run: traced.followed(self._beside[run], held[run])
            for run, traced in self._traces.items()
        }
        along = self._rates(self._beside, motions, self.measures)
        columns = [
            np.tensordot(self._shares.T, rates, 1) + own
            for rates, own in zip(along, self._direct(held), strict=True)
        ]
        return [list(column) for column in zip(*columns, strict=True)]

    def _direct(self, held: Mapping[str, dict[str, object]]) -> list[Array]:
        """Return the derivatives (p, ...) of the arrays by stresses of the same motion."""
        assert self._last is not None
        direct = [np.zeros((self._shares.shape[1], *raw.shape)) for raw in self._last[2]]
        if self._moving:
            still = {
                run: traced.still(self._stresses[run], held[run])
                for run, traced in self._traces.items()
            }
            rates = self._rates(self._stresses, still, self._stressed)
            for each, own in zip(direct, rates, strict=True):
                each[self._moving] = own
        return direct

    def _held(self) -> dict[str, dict[str, object]]:
        """Return by run the points of plies that govern in the last design, where that is known.

        Beside the design they are the same.
        """
        assert self._last is not None
        _, made, _, weights = self._last
        held: dict[str, dict[str, object]] = {run: {} for run in self._traces}
        if made.recording is not None:
            memory = {HELD: held[self.study.table.run]}
            recording = Recording(made.recording.model, made.t, made.recording.y, memory)
            for m, w in zip(self.measures, weights, strict=True):
                m.raw(replace(made, recording=recording), w)
        return held

    def _rates(
        self,
        parameters: Mapping[str, Sequence[Parameter]],
        motions: Mapping[str, Followed],
        measures: Collection[Measure],
    ) -> list[Array]:
        """Return the derivatives (r, ...) of the arrays of some measures by parameters (r).

        They are zero of other measures, and where the values of the design do not depend on them.
        """
        assert self._last is not None
        (_, _, raws, weights), run = self._last, self.study.table.run
        rates = [np.zeros((len(parameters[run]), *raw.shape)) for raw in raws]
        for k, parameter in enumerate(parameters[run]):
            low, high = made_beside(run, self._traces, motions, k, parameter)
            for m, w, own in zip(self.measures, weights, rates, strict=True):
                if m in measures:
                    change = change_of(m.raw(low, w), m.raw(high, w), m.unit)
                    own[k] = change / (2.0 * parameter.h)
        return rates

    def why_not_exact(self) -> str:
        """Return what has no exact derivative; "" if all quantities have one."""
        if self.runs and self._plan is not None:
            return "a run with [fidelity] has no exact derivative"
        self.exact = True
        try:
            why = self.values(self.study.start).why
            if not why:
                self._exact()
            return why
        except InputError as error:
            return _line(error)
        finally:
            self.exact, self._last = self.given.exact, None

    # How a design is made.

    def differentiable(self) -> tuple[RunSpec, list[Parameter]]:
        """Return the run of the first design, whose packages have all derivatives; its parameters.

        Raises
        ------
        InputError
            Why there are none.
        """
        made = self._made_exact(self.study.start, all_of_them=True)
        if isinstance(made, str) or self._refused:
            raise InputError(made if isinstance(made, str) else self._refused)
        beside = zip(self._beside[self.study.table.run], self.study.start, strict=True)
        return made.spec, [
            replace(each, unit=self.study.unit(each.name), value=float(value))
            for each, value in beside
        ]

    def _made_exact(self, p: Array, *, all_of_them: bool = False) -> Made | str:
        """Return a design whose packages carry derivatives; of an invalid one, why.

        They have those that the quantities of the study depend on, or all of them.
        """
        names, steps = list(self.study.parameters), self.steps(STEP)
        try:
            ranges = np.array([q.range() for q in self.study.parameters.values()])
            designs = self.study.designs(beside(p, steps, ranges))
            own, count = designs.own, 1 + 2 * p.size
            runs = {self.study.table.run: own, **designs.others}
            without = [] if all_of_them else self._without(runs)
            built: list[tuple[str, BodySpec]] = []
            for members in runs.values():
                bodies = [model_and_check(members.bodies[k])[0] for k in range(count)]
                members.bodies[0] = with_targets(names, bodies, steps, without)
                built += members.bodies[0].items()
            files = self.build(built)
        except InputError as error:
            self._refused = _line(error)
            return self._refused
        self._refused = next(iter(self._failed.values()), "")
        try:
            self._traces.clear()
            made = self._run(own, designs.others, 0, files, self._traces)
            if isinstance(made, Made):
                specs = {
                    run: made.spec if members is own else self.spec(run, members, 0, files)
                    for run, members in runs.items()
                }
                self._part(specs, runs, steps, without, whole=all_of_them)
        finally:
            self.forget(files)
        return made

    def _part(
        self,
        specs: Mapping[str, RunSpec],
        runs: Mapping[str, Members],
        steps: Array,
        without: Sequence[str],
        *,
        whole: bool,
    ) -> None:
        """Keep the parameters by which the runs of a design are differentiated.

        Parameters of sections change nothing but packages, and these in fewer ways than there are
        plies, but for what stresses are made of.
        """
        names = list(self.study.parameters)
        parts = {
            run: (spec, replace(spec, packages={})) if whole else parted(spec)
            for run, spec in specs.items()
        }
        apart = [
            k
            for k, targets in enumerate(self.study.targets[name] for name in names)
            if whole or not all(target.key.startswith("sections.") for target in targets)
        ]
        kept, self._shares = combined([motion for motion, _ in parts.values()], names, apart)
        packages = [p for _, stresses in parts.values() for p in stresses.packages.values()]
        moved = {one.name for p in packages for one in p.design if one.values}
        self._moving = [k for k, n in enumerate(names) if n in moved and self._stressed]
        for run, members in runs.items():
            motion, stresses = parts[run]
            sides = [
                (self.mechanism(members, 1 + 2 * k), self.mechanism(members, 2 + 2 * k))
                for k in kept
            ]
            own, moving = [names[k] for k in kept], [names[k] for k in self._moving]
            self._beside[run] = runs_beside(motion, own, steps[kept], sides, without)
            self._stresses[run] = runs_beside(stresses, moving, steps[self._moving])

    def _without(self, runs: Mapping[str, Members]) -> list[str]:
        """Return which derivatives of beams no quantity depends on; see `with_targets`."""
        own = self.study.base.signals

        def stressed(quantity: Quantity) -> bool:
            read = with_parts([quantity.name], own) if quantity.subject == "signal" else {}
            signals = [*read.values()]
            for run, names in needed(read).items():
                signals += with_parts(names, runs[run].base.signals).values()
            return quantity.subject == "strength" or any(
                isinstance(signal, PlyStressSignal | StrengthSignal) for signal in signals
            )

        self._stressed = [m for m in self.measures if stressed(m.quantity)]
        second_order = any(each.base.solver.geometric_stiffening for each in runs.values())
        without = ["ply_axes"] if self._stressed else ["ply_axes", "stresses"]
        return without if second_order else [*without, "second_order"]

    def _made(self, points: Sequence[Array]) -> list[Made | str]:
        """Return designs that were built and run; of an invalid one, why."""
        try:
            designs = self.study.designs(points)
        except InputError as error:
            if len(points) > 1:
                return [each for p in points for each in self._made([p])]
            return [_line(error)]
        everyone = [designs.own, *designs.others.values()]
        specs = [s for m in everyone for each in m.bodies for s in model_and_check(each)[0].items()]
        files = self.build(specs)
        try:
            return [self._run(designs.own, designs.others, k, files) for k in range(len(points))]
        finally:
            self.forget(files)

    def forget(self, files: Mapping[str, Path]) -> None:
        """Remove packages that `build` has made: those of all designs would fill a disk."""
        for file in files.values():
            file.unlink(missing_ok=True)
            file.with_suffix(".json").unlink(missing_ok=True)

    def build(self, specs: Sequence[tuple[str, BodySpec]]) -> dict[str, Path]:
        """Build packages; return their files by the digest of their inputs.

        A body that cannot be built has none.
        """
        # Two processes may come to the same design, such as one at a bound.
        folder = self.given.folder / BODIES / str(os.getpid())
        folder.mkdir(parents=True, exist_ok=True)
        files: dict[str, Path] = {}
        for name, spec in specs:
            if spec.inputs_sha256 not in files:
                file = folder / f"{name}.{spec.inputs_sha256[:16]}{PACKED}"
                table = {**spec.content, "inputs_sha256": spec.inputs_sha256}
                write_text(file.with_suffix(".json"), dump(table))
                files[spec.inputs_sha256] = file
        self._failed.clear()
        level, logger = LOGGER.getEffectiveLevel(), logging.getLogger("plymotion")
        logger.setLevel(logging.CRITICAL)  # a line for each package of each design
        try:
            wanted = [f.with_suffix(".json") for f in files.values()]
            build_packages(wanted, folder, executor=lambda: Local(1, threads=True), packed=True)
        except BodiesFailed as error:
            self._failed = {spec.with_suffix(PACKED): why for spec, why in error.reasons.items()}
        finally:
            logger.setLevel(level)
        return files

    def _run(
        self,
        own: Members,
        others: Mapping[str, Members],
        k: int,
        files: Mapping[str, Path],
        traces: dict[str, Traced] | None = None,
    ) -> Made | str:
        """Return the design k of some, run; why if that is impossible or invalid."""
        try:
            spec = self.spec(self.study.table.run, own, k, files)
            elsewhere = {run: self.spec(run, m, k, files) for run, m in others.items()}
            return self.run(spec, elsewhere, traces)
        except (InputError, PackageError, *ERRORS) as error:
            return _line(error)

    def spec(self, run: str, members: Members, k: int, files: Mapping[str, Path]) -> RunSpec:
        """Return a run of a design with its packages.

        Parameters
        ----------
        run : name of the run
        members : the designs of this run
        k : number of the design among them
        files : package files by digest of the specification

        Raises
        ------
        PackageError
            A package of the user that cannot be read.
        InputError
            A package that could not be built.
        """
        mechanism, specs = self.mechanism(members, k), model_and_check(members.bodies[k])[0]
        for name, s in specs.items():
            if why := self._failed.get(files[s.inputs_sha256]):
                raise InputError(f"bodies.{name}: {why}")
        packages: dict[str, ModalPackage] = {
            name: unpacked(files[s.inputs_sha256].read_bytes()) for name, s in specs.items()
        }
        for name, body in mechanism.bodies.items():
            if isinstance(body, PackageBody):
                # its own derivatives are by other parameters, whatever their names
                package = read_package(self.given.file.parent / body.package)
                packages[name] = replace(package, design=())
        return RunSpec(self.case, run, mechanism, packages)

    def mechanism(self, members: Members, k: int) -> Mechanism:
        """Return the mechanism of a design, in the bodies that are built."""
        rtol = min(members.base.solver.rtol, self.study.table.rtol)
        changes = {**members.changes[k], "solver.rtol": rtol}
        return in_segments(changed_mechanism(members.base, changes))

    def run(
        self,
        spec: RunSpec,
        others: Mapping[str, RunSpec],
        traces: dict[str, Traced] | None = None,
    ) -> Made | str:
        """Integrate a run if a measure needs it; return why it is invalid if it is.

        Parameters
        ----------
        spec : the run
        others : runs that its signals read, by name
        traces : gets what tangents need, of the run and of those that its signals read

        Raises
        ------
        KeyboardInterrupt
            A signal has ended it.
        """
        if not self.runs:
            return Made(spec, None, {}, None)
        if self._plan is not None:
            from ..fidelity.checked_run import member_spec  # most studies need no planner

            spec = member_spec(spec, self._plan)
        kept = {q.name for q in self.study.table.quantities() if q.subject == "signal"}
        read = with_parts(kept, spec.mechanism.signals)

        def taken(run: str, prepared: Prepared) -> FinishedRun:
            trace = None if traces is None else Trace(prepared)
            look = LOOK if run == spec.run else None
            finished = integrated(prepared, trace, look, stages=trace is not None)
            if finished.solution.status == "interrupted":
                raise KeyboardInterrupt
            if traces is not None and trace is not None:
                names = kept if run == spec.run else needed(read)[run]
                traces[run] = Traced(prepared, finished, trace, names)
            return finished

        histories = histories_of(read, others, spec.mechanism.solver, integrate=taken)
        prepared = prepare(spec.mechanism, spec.packages, kept, histories=histories)
        finished = taken(spec.run, prepared)
        if finished.solution.status != "finished":
            return f"the run ended at {finished.solution.t[-1]:.4g} s: {finished.solution.message}"
        wrong = [f.text for f in checked(finished) if f.level == "error"]
        if wrong:
            return few(wrong[:1])
        recording = Recording(finished.model, finished.solution.t, finished.solution.y)
        return Made(spec, finished, prepared.measured, recording)


def _contracted(weights: Array, rates: Array) -> Array:
    """Return derivatives (r, p) of values from weights (r, ...) and those of arrays (p, ...)."""
    return np.asarray(weights.reshape(len(weights), -1) @ rates.reshape(len(rates), -1).T)


def _line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
