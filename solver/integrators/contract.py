"""What the file of an integrator supplies.

An integrator is a class derived from `Integrator` (generic/base.py), in one file. Nothing else
names it: table.py finds the class by its `name`, inputs/case/tables/solver.py makes the keys of
`[solver]`, choice.py makes the integrator of a case. CONTRIBUTING.md has the recipe.

For the case file:
    name : value of `[solver] integrator`
    meaning : half a line for docs/case-reference.md, without full stop
    keys : `Number`s of `[solver]` that only this integrator has; keyword arguments of its
        `__init__` by the same names
    treatments : treatments of the constraints that it solves within the step
        (IMPLICIT, dynamics/elements/constraints/treatment.py); none: it takes all others
    place : in the manual and in lists; those of equal place follow by name

First argument, by `takes`:
    "derivative"   f(t, y) -> (n,): y' = f. The class knows numbers, never a body; it is of use
                   for any equation and belongs in generic/.
    "model"        a `Model` (dynamics/model/model.py): for step loops that are compiled whole
                   (`StepLoop`, step_loop.py). It belongs in this folder.

It must have:
    order : int, order of the method; sizes of first steps follow from it
    _attempt(h, t_new) -> y (n,) at t_new, or None with `_trouble` (why) and a smaller `_h_next` [s]
        set, and after `_refuse_not_finite` where numbers are not finite; or an `_advance` of its
        own, which takes one accepted step
    _dense() -> callable of times () or (k,) [s] inside the last step, giving (n,) or (k, n)

It sets `_h_next` [s], the size of the next step, and counts what `Counters` name; `derivative`
counts evaluations. A step is accepted when the local error, in units of the tolerance (`norm`), is
below 1, and after `project`, which brings it back onto the constraints. With `fixed_step` there is
no error control.

It may have:
    for_treatment(name) : options that follow from `[solver] constraints`
    on_growth, fails_before_growth, on_failure, on_any_failure : words on runs that fail
    limited_above, _look_back : hints on finished runs
    strides, stride, steps_taken, take_up : many steps in one call, shown to a watch afterwards
        (generic/steps.py; `StepLoop` has them)
"""

from ..math.catalogue import Number
from .generic.base import Counters, Dense, Derivative, Integrator
from .step_loop import StepLoop

__all__ = [
    "Counters",
    "Dense",
    "Derivative",
    "Integrator",
    "Number",
    "StepLoop",
]
