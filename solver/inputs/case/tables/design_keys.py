"""`[design]` of a case file: parameters of the design, and studies that search for the best one."""

from typing import Any, Literal, Self

from pydantic import model_validator

from ...common.input_table import Name, Pair, Table, Word, entry, optional

MECHANISM = "mechanism"  # in place of the name of a body
Reduction = Literal["max", "min", "rms", "at"]
SUBJECTS = ("signal", "strength", "frequency", "mass", "section", "deformation_energy")


class Target(Table):
    """One entry of `of` of a design parameter: a key that gets factor * parameter + offset."""

    key: str = entry("dotted key of a number, as in sweeps")
    factor: float = entry("of the parameter", default=1.0)
    offset: float = entry("added to it, in the unit of the key", default=0.0)


class DesignParameter(Table):
    """`[design.parameters.NAME]`: a number of the design that studies vary (docs/design.md)."""

    of: list[str | Target] = entry(
        'dotted keys that get the value, such as "bodies.arm.ply_angle_deg" or '
        '"sections.tube:laminates.wall.plies.0.angle_deg"; or tables with key, factor, offset',
        min_length=1,
    )
    kind: Literal["angle", "thickness", "number", "choice"] = entry(
        "angle: of plies, keys in deg; thickness: keys in m; number: any key; choice: one of `set`,"
        " numbers or names such as those of materials, without values between them"
    )
    bounds: Pair | None = optional("lowest and highest value; absent: those of `set`")
    values: list[float] | list[str] | None = optional(
        'the allowed values of a discrete parameter; names with kind = "choice"',
        min_length=2,
        alias="set",
    )
    step: float | None = optional("discrete: multiples of it within the bounds", gt=0)
    start: float | str | None = optional("first value of a study; absent: that of the case")

    @model_validator(mode="after")
    def _fitting(self) -> Self:
        if self.bounds is not None and not self.bounds[0] < self.bounds[1]:
            raise ValueError(f"bounds = {self.bounds}: expected the lower bound first")
        if self.values is not None and self.step is not None:
            raise ValueError("expected `set` or `step`, not both")
        if self.kind == "choice" and self.values is None:
            raise ValueError('kind = "choice": expected `set`')
        if self.bounds is None and self.values is None:
            raise ValueError("expected `bounds` or `set`")
        if self.step is not None and self.bounds is not None and len(self.allowed()) < 2:
            raise ValueError(f"step = {self.step:g}: expected two multiples within the bounds")
        low, high = self.range()
        if self.names:
            if self.kind != "choice" or self.bounds is not None or len({*self.names}) < 2:
                words = 'names of kind = "choice", without bounds, no two of them equal'
                raise ValueError(f"set: expected {words}")
            if any(isinstance(t, Target) and (t.factor, t.offset) != (1.0, 0.0) for t in self.of):
                raise ValueError("of: expected no factor and no offset of names")
            if self.start is not None and self.start not in self.names:
                raise ValueError(f"start = {self.start!r}: expected one of {', '.join(self.names)}")
        elif isinstance(self.start, str):
            raise ValueError(f"start = {self.start!r}: expected a number")
        elif self.start is not None and not low <= self.start <= high:
            raise ValueError(f"start = {self.start:g}: expected {low:g} to {high:g}")
        return self

    @property
    def names(self) -> list[str]:
        """The allowed names; the value of such a parameter is the place in this list."""
        return [value for value in self.values or () if isinstance(value, str)]

    def shown(self, value: float) -> float | str:
        """Return a value as the user writes it."""
        return self.names[round(value)] if self.names else float(value)

    def range(self) -> tuple[float, float]:
        """Return the lowest and the highest value."""
        if self.bounds is not None:
            return self.bounds[0], self.bounds[1]
        values = self._numbers() or [0.0]
        return min(values), max(values)

    def _numbers(self) -> list[float]:
        values: list[Any] = [*(self.values or ())]
        return [float(k if isinstance(v, str) else v) for k, v in enumerate(values)]

    def allowed(self) -> list[float]:
        """Return the values of a discrete parameter in order; none of a continuous one."""
        low, high = self.range()
        near = 1e-9 * (high - low)
        if self.values is not None:
            return sorted(v for v in {*self._numbers()} if low - near <= v <= high + near)
        if self.step is None:
            return []
        first, last = -(-(low - near) // self.step), (high + near) // self.step
        return [self.step * k for k in range(int(first), int(last) + 1)]


class Quantity(Table):
    """`minimise`, `maximise` of a study: the number that is made small or large."""

    signal: Name | None = optional("name of a signal; with `of`")
    strength: Name | None = optional(
        "name of a body: lowest strength ratio of its plies over the run"
    )
    frequency: Name | None = optional(
        'name of a body, or "mechanism" (about its start): lowest natural frequency [Hz]; close '
        "frequencies count together, so that the order of the modes does not matter"
    )
    mass: Name | None = optional('name of a body, or "mechanism" [kg]')
    section: Name | None = optional("name of a beam; with `entry`")
    entry: str | None = optional(
        '"K11" to "K66", of the 6x6 stiffness of its first section, or "S11" to "S66", of the '
        "flexibility",
        pattern="^[KS][1-6][1-6]$",
    )
    deformation_energy: Name | None = optional(
        'name of a flexible body, or "mechanism": elastic energy [J]; with `of`'
    )
    of: Reduction | None = optional(
        "of a signal or energy: max or min (each local peak is a constraint of its own), rms over "
        "time, or at a time"
    )
    low: float | None = optional("begin of the span of time; absent: start", "s", alias="from")
    high: float | None = optional("its end; absent: end of the run", "s", alias="to")
    time: float | None = optional("of `at`", "s", ge=0)

    @model_validator(mode="before")
    @classmethod
    def _no_number_of_a_mode(cls, table: Any) -> Any:
        if isinstance(table, dict) and {"mode", "number"} & table.keys():
            raise ValueError(
                "a mode cannot be chosen by its number: modes change their order with the design, "
                "and those of round and square sections always have equal frequencies; expected "
                "`frequency` (the lowest of a body), or a signal"
            )
        return table

    @model_validator(mode="after")
    def _one_subject(self) -> Self:
        named = [name for name in SUBJECTS if getattr(self, name) is not None]
        if len(named) != 1:
            raise ValueError(f"expected one of {', '.join(SUBJECTS)}, found {len(named)}")
        over_time = named[0] in ("signal", "deformation_energy")
        if over_time != (self.of is not None):
            example = ', such as of = "rms"' if over_time else ""
            raise ValueError(f"{named[0]}: expected {'a' if over_time else 'no'} key `of`{example}")
        if (self.of == "at") != (self.time is not None):
            raise ValueError('expected `time` with of = "at", and only there')
        if (named[0] == "section") != (self.entry is not None):
            raise ValueError("expected `entry` with `section`, and only there")
        if None not in (self.low, self.high) and not self.low < self.high:  # type: ignore[operator]
            raise ValueError("from, to: expected the earlier time first")
        return self

    @property
    def subject(self) -> str:
        """Which of SUBJECTS it is."""
        return next(name for name in SUBJECTS if getattr(self, name) is not None)

    @property
    def name(self) -> str:
        """What it is of: name of a signal or body."""
        return str(getattr(self, self.subject))

    def words(self) -> str:
        """Return the quantity for tables and figures."""
        more = f" {self.of}" if self.of else ""
        more += f" {self.time:g} s" if self.time is not None else ""
        entry = f"{self.entry} of " if self.entry else ""
        return f"{entry}{self.subject.replace('_', ' ')} {self.name}{more}"


class Limit(Quantity):
    """One entry of `subject_to` of a study: a quantity with a least or largest value."""

    least: float | None = optional("least value", alias="min")
    most: float | None = optional("largest value", alias="max")

    @model_validator(mode="after")
    def _limited(self) -> Self:
        if self.least is None and self.most is None:
            raise ValueError("expected `min`, `max` or both")
        if None not in (self.least, self.most) and self.least > self.most:  # type: ignore[operator]
            raise ValueError(f"min = {self.least:g}: expected at most max = {self.most:g}")
        wrong = {"max": "least", "min": "most"}.get(self.of or "")
        wrong = "most" if self.subject in ("strength", "frequency") else wrong
        if wrong and getattr(self, wrong) is not None:
            key = {"least": "min", "most": "max"}[wrong]
            raise ValueError(f"{self.words()}: expected no `{key}`, which its extreme cannot keep")
        return self


class Rule(Table):
    """One entry of `rules` of a study, besides "symmetric" and "balanced"."""

    one_of = ("share", "equal_plies", "step")

    share: float | None = optional("least share of plies at 0, 45, -45, 90 deg each", gt=0, le=0.25)
    equal_plies: int | None = optional("most plies of one angle in sequence", ge=1)
    step: float | None = optional("largest angle between neighbouring plies", "deg", gt=0, le=90)


class Study(Table):
    """`[design.studies.NAME]`: the search for the best design of a run (docs/design.md)."""

    one_of = ("minimise", "maximise")

    title: str = entry("words for reports", default="")
    run: Name = entry("name of the run")
    parameters: list[Name] | None = optional("names of those that vary; absent: all", min_length=1)
    minimise: Quantity | None = optional("what is made small")
    maximise: Quantity | None = optional("in its place: what is made large")
    front: Quantity | None = optional(
        "a second number, for the designs of which none is better in both; made large if it is a "
        'strength, a frequency or a min, else small; with driver = "genetic"'
    )
    subject_to: list[Limit] = entry("limits", default=[])
    rules: list[Literal["symmetric", "balanced"] | Rule] = entry("of the lay-ups", default=[])
    driver: Name = entry("optimiser, see docs/design.md", default="slsqp")
    starts: int = entry("designs at which it begins: that of the case, then Sobol points", ge=1,
                        default=8)  # fmt: skip
    seed: int = entry("of the Sobol points", default=0, ge=0)
    iterations: int = entry("most iterations of a start", default=60, ge=1)
    tolerance: float = entry("change of the objective, relative, that ends a start", default=1e-6,
                             gt=0, lt=1)  # fmt: skip
    gradient: Literal["exact", "differences"] | None = optional(
        "exact: derivatives by packages and the tangent of the run; differences: central "
        "differences of designs that are built again, with their step and noise in the report; "
        "absent: exact if every quantity has it"
    )
    difference: float = entry("step of differences, of the range of a parameter", default=1e-3,
                              gt=0, lt=0.1)  # fmt: skip
    rtol: float = entry("largest tolerance of the runs of a study", default=1e-6, gt=0, lt=1)
    verify: bool = entry("compute the best design with a richer model at the end", default=True)

    @model_validator(mode="after")
    def _one_objective(self) -> Self:
        wrong = "min" if self.minimise is not None else "max"
        only = self.minimise is not None and self.objective.subject in ("strength", "frequency")
        if self.objective.of == wrong or only:
            key = "maximise" if self.minimise is not None else "minimise"
            least = "; a downward deflection is negative: it is smaller if its minimum is larger"
            hint = least if self.objective.of == "min" else ""
            raise ValueError(f"{self.objective.words()}: expected under `{key}`{hint}")
        if self.front is not None and self.driver != "genetic":
            raise ValueError(f'driver = "{self.driver}": expected "genetic" with `front`')
        return self

    @property
    def objective(self) -> Quantity:
        """What is made small or large."""
        quantity = self.minimise or self.maximise
        assert quantity is not None
        return quantity

    def quantities(self) -> list[Quantity]:
        """Return the objective, then the limits, then what `front` names."""
        return [self.objective, *self.subject_to, *([self.front] if self.front else [])]


class Design(Table):
    """`[design]`: parameters of the design, and studies."""

    parameters: dict[Word, DesignParameter] = entry("what may vary", default={})
    studies: dict[Name, Study] = entry("what is searched for", default={})
