"""Compiling our functions changes nothing of what Numba makes of a user's own functions."""

import os
from importlib.util import find_spec

import pytest
from harness.processes import this_python

# Not `importorskip`: Numba takes long to load, and each worker of pytest reads this file.
pytestmark = pytest.mark.skipif(find_spec("numba") is None, reason="Numba is not installed")

OURS = """
from plymotion.solver.math.compiled import lean

@lean
def ours(x, y, a):
    return abs(x * y) + abs(x / y) + min(a[0], a[1], 2.0) + a[0] ** 3
"""
# The same functions of a user are compiled before and after one of ours. Numba numbers them, so
# names of symbols, constants with these names, and addresses of its objects are left out.
SCRIPT = """
import re
import numpy as np
from numba import njit

INF, NAN = float("inf"), float("nan")
NUMBERS = [0j, 1 + 2j, complex(INF, 0), complex(0, INF), complex(INF, NAN), complex(1e200, 1e200)]
TEXTS = ["x * y", "x / y", "abs(x) + 0 * y", "x.real ** int(y.real)", "min(x.real, y.real)",
         "np.array([1.0, 2.0])[int(x.real) - 1] + y", "np.ones(int(x.real)).sum() + y"]

def outcome(function, x, y):
    try:
        return repr(function(x, y))
    except Exception as error:
        return repr(error)

def seen():
    found = []
    for text in TEXTS:
        function = njit(eval(f"lambda x, y: {text}", {"np": np}))
        finite = NUMBERS[:2] if "int" in text else NUMBERS
        values = [outcome(function, x, y) for x in finite for y in finite]
        (code,) = function.inspect_llvm().values()
        lines = [line for line in code.splitlines() if "missing Environment" not in line]
        found.append((text, values, re.sub("_ZN[^ (]+|0x[0-9a-f]+", "symbol", chr(10).join(lines))))
    return found

before = seen()
import sample
from plymotion.solver.math.compiled import statistics
sample.ours(1 + 2j, 2 - 1j, np.ones(2))
assert statistics.compiled == ["sample:ours"], (statistics.compiled, statistics.fallbacks)
for (text, values, code), (_, values_after, code_after) in zip(before, seen(), strict=True):
    assert values == values_after, (text, values, values_after)
    assert code == code_after, text
"""


def test_functions_of_a_user_are_compiled_as_before(tmp_path):
    (tmp_path / "sample.py").write_text(OURS)
    path = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH")]))
    changes = {"PYTHONPATH": path, "PLYMOTION_CACHE": str(tmp_path / "cache")}
    changes |= {"PLYMOTION_COMPILED": "1"}
    done = this_python("-c", SCRIPT, more=changes)
    assert done.returncode == 0, done.stderr
