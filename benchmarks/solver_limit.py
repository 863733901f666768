"""Operations and memory of one evaluation, and how far its time is from what the processor can do.

The operations are counted: the same functions, not compiled, work on numbers that count. What the
processor can do is the rate of a product of matrices by the BLAS of NumPy, with one thread.
"""

import json
import math
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from solver_methods import DEFAULT
from solver_problems import Problem, chain, double_pendulum

from plymotion.solver.dynamics.evaluation.accelerations import derivative_into
from plymotion.solver.dynamics.evaluation.evaluation import evaluate
from plymotion.solver.dynamics.model.coordinates import rates_into
from plymotion.solver.dynamics.model.model import new_workspace
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.run.preparation import prepare

PROBLEMS: dict[str, Callable[[], Problem]] = {
    "double pendulum, 4 + 4 modes": double_pendulum,
    "chain of 64 links, 4 modes each": lambda: chain(64, 0.05),
}
RTOL = 1e-4
REPEATED = 9  # the least time of so many rounds
CALLS = 2000  # of a function in a round
SIZE = 36  # of the matrices: three of them fill the first cache
COUNTS: Counter[str] = Counter()


class Counted:
    """A number that counts the operations done with it."""

    __slots__ = ("value",)

    def __init__(self, value: Any) -> None:
        self.value = float(value)

    def __float__(self) -> float:
        return self.value

    def __neg__(self) -> "Counted":
        return Counted(-self.value)

    def __abs__(self) -> "Counted":
        return Counted(abs(self.value))


def _operation(name: str, kind: str) -> Callable[[Any, Any], Counted]:
    of_float = getattr(float, name)

    def counted(self: Any, other: Any) -> Counted:
        COUNTS[kind] += 1
        return Counted(of_float(self.value, float(other)))

    return counted


def _comparison(name: str) -> Callable[[Any, Any], bool]:
    of_float = getattr(float, name)
    return lambda self, other: bool(of_float(self.value, float(other)))


def _function(name: str) -> Callable[[Any], Counted]:
    of_float = getattr(math, name)

    def counted(self: Any) -> Counted:
        COUNTS["functions"] += 1
        return Counted(of_float(self.value))

    return counted


for _kind, _names in {
    "sums": ("add", "radd", "sub", "rsub"),
    "products": ("mul", "rmul", "pow"),
    "divisions": ("truediv", "rtruediv"),
}.items():
    for _name in _names:
        setattr(Counted, f"__{_name}__", _operation(f"__{_name}__", _kind))
for _name in ("lt", "gt", "le", "ge", "eq", "ne"):
    setattr(Counted, f"__{_name}__", _comparison(f"__{_name}__"))
for _name in ("sqrt", "sin", "cos", "exp"):  # NumPy calls these methods of objects
    setattr(Counted, _name, _function(_name))


def _counting(value: Any) -> Any:
    """A copy of arrays and structures whose numbers count."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind != "f":
            return value
        return np.array([Counted(x) for x in value.ravel()], dtype=object).reshape(value.shape)
    if hasattr(value, "_fields"):
        return type(value)(*map(_counting, value))
    return value


def operations(name: str) -> dict[str, dict[str, int]]:
    """Operations of an evaluation of the equations, and of one with the accelerations."""
    spec = PROBLEMS[name]().with_solver(DEFAULT, RTOL)
    prepared = prepare(spec.mechanism, spec.packages)
    model, work, y = map(_counting, (prepared.model, new_workspace(prepared.model), prepared.y0))
    out = _counting(np.zeros(prepared.y0.size))
    found = {}
    for what, call in (
        ("evaluation", lambda: evaluate(model, work, 0.0, y)),
        ("accelerations", lambda: derivative_into(model, work, 0.0, y, out)),
    ):
        COUNTS.clear()
        call()
        found[what] = dict(COUNTS)
    return found


def peak() -> float:
    """Operations per second of a product of matrices in the first cache."""
    one = np.ones((SIZE, SIZE))
    two, out = one.copy(), one.copy()
    return 2.0 * SIZE**3 / _least(lambda: np.matmul(one, two, out=out))


def measure() -> dict[str, Any]:
    """Rate of the processor; operations, memory and times of each problem."""
    return {"peak": peak(), "problems": {name: _measured(name) for name in PROBLEMS}}


def _measured(name: str) -> dict[str, Any]:
    spec = PROBLEMS[name]().with_solver(DEFAULT, RTOL)
    prepared = prepare(spec.mechanism, spec.packages)
    model, y0 = prepared.model, prepared.y0
    work, out = new_workspace(model), np.zeros(y0.size)
    empty = model._replace(n_body=0)
    steps = []
    for _ in range(REPEATED):
        one = make_integrator(model, y0, spec.mechanism.solver, prepared.treatment)
        begin = time.process_time()
        counters = integrate(one, [one.t_end]).counters
        steps.append((time.process_time() - begin) / (counters.steps + counters.rejected))
    call = _least(lambda: rates_into(empty, y0, out))  # Python's part of a call
    environment = dict(os.environ, PLYMOTION_COMPILED="0")
    counted = subprocess.run(
        [sys.executable, __file__, name], env=environment, check=True, capture_output=True
    )
    return {
        "operations": json.loads(counted.stdout),
        "bytes": _bytes(model) + _bytes(work),
        "evaluation_s": _least(lambda: evaluate(model, work, 0.0, y0)) - call,
        "accelerations_s": _least(lambda: derivative_into(model, work, 0.0, y0, out)) - call,
        "radau_step_s": min(steps),
        "evaluations_per_step": counters.evaluations / (counters.steps + counters.rejected),
    }


def _bytes(value: Any) -> int:
    if isinstance(value, np.ndarray):
        return value.nbytes
    return sum(map(_bytes, value)) if isinstance(value, tuple) else 0


def _least(call: Callable[[], Any]) -> float:
    """Least time of a call [s]."""
    call()
    found = []
    for _ in range(REPEATED):
        begin = time.process_time()
        for _ in range(CALLS):
            call()
        found.append((time.process_time() - begin) / CALLS)
    return min(found)


if __name__ == "__main__":
    print(json.dumps(operations(sys.argv[1])))
