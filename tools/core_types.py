"""Run some tests with every kernel of OpenBLAS that this processor has.

OpenBLAS chooses its kernels by the type of the processor's cores, and rounds differently with
each; OPENBLAS_CORETYPE chooses another one. A test whose verdict changes with it compares
rounding with rounding.
"""

import ctypes
import hashlib
import importlib
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from side_by_side import Done, Job

# What the kernels need, in the words of /proc/cpuinfo.
FLAGS = {
    "Prescott": {"pni"},
    "Nehalem": {"sse4_2"},
    "Haswell": {"avx2", "fma"},
    "Zen": {"avx2", "fma"},
    "SkylakeX": {"avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"},
}
VERBOSE = {"OPENBLAS_VERBOSE": "2"}


@dataclass(frozen=True)
class Tests:
    """Tests of one interpreter.

    Attributes
    ----------
    title : what runs them, for the summary
    python : the interpreter
    loads : module whose import loads all that the tests use of OpenBLAS
    arguments : of pytest
    numbers : folder for the numbers that they record, one folder for each type; None: they do not
    """

    title: str
    python: str
    loads: str
    arguments: tuple[str, ...]
    numbers: Path | None = None


def available(flags: set[str]) -> list[str]:
    """Core types whose kernels a processor with these flags can run."""
    return [name for name, needed in FLAGS.items() if needed <= flags]


def processor_flags(file: Path = Path("/proc/cpuinfo")) -> set[str]:
    """Flags of this processor; none where the system does not tell them."""
    text = file.read_text() if file.exists() else ""
    found = re.search(r"^flags\s*:(.*)$", text, re.MULTILINE)
    return set(found[1].split()) if found else set()


def variables(core_type: str, numbers: Path | None) -> dict[str, str]:
    """Variables with which tests run with the kernels of a type."""
    changed = {"OPENBLAS_CORETYPE": core_type, "OPENBLAS_NUM_THREADS": "1"}
    if numbers is not None:
        changed["PLYMOTION_FE_NUMBERS"] = str(numbers / core_type)
    return changed


@dataclass(frozen=True)
class Kernels:
    """What the copies of OpenBLAS of an interpreter really use with a core type.

    Attributes
    ----------
    names : of the kernels; none if there is no such copy, or if one does not know the type
    rounding : digests of results (this program); types with equal ones round alike. The names,
        if they could not be computed
    """

    names: frozenset[str]
    rounding: frozenset[str]


def kernels(tests: Tests, core_type: str) -> Kernels:
    """The kernels that tests use with a core type; the processor's own with an empty name."""
    done = subprocess.run(
        [tests.python, str(Path(__file__)), tests.loads],
        env={**os.environ, **(variables(core_type, None) if core_type else {}), **VERBOSE},
        capture_output=True,
        text=True,
    )
    names = frozenset(re.findall(r"^Core: (\w+)$", done.stderr, re.MULTILINE))
    if "Core not found" in done.stderr:
        names = frozenset()
    digests = frozenset(() if done.returncode else done.stdout.split())
    return Kernels(names, digests or names)


@dataclass(frozen=True)
class Choice:
    """Core types to run some tests with.

    Attributes
    ----------
    own : names of the kernels that all tests use, the processor's unless the user says otherwise
    types : core types that round otherwise, each once
    alike : core types that round like `own` or like one of `types`
    """

    own: frozenset[str]
    types: tuple[str, ...]
    alike: tuple[str, ...] = ()


def choice(tests: Tests) -> Choice:
    """The core types of this processor that differ for these tests."""
    own = kernels(tests, os.environ.get("OPENBLAS_CORETYPE", ""))
    seen = {own.rounding}
    types: list[str] = []
    alike: list[str] = []
    for core_type in available(processor_flags()):
        found = kernels(tests, core_type)
        if found.names:
            (alike if found.rounding in seen else types).append(core_type)
            seen.add(found.rounding)
    return Choice(own.names, tuple(types), tuple(alike))


def job(tests: Tests, core_type: str, after: Job | None = None) -> Job:
    """The run of the tests with the kernels of one type, after another run."""
    command = (tests.python, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests.arguments)
    title = f"{tests.title}, core type {core_type}"
    return Job(title, command, environment=variables(core_type, tests.numbers), after=after)


def summary(title: str, choice: Choice, results: list[Done]) -> str:
    """One line: which types were run (one result for each type of the choice) and which failed."""
    if not choice.own:
        return f"{title}: NO CORE TYPES, it has no OpenBLAS that can choose its kernels"
    own = "+".join(sorted(choice.own))
    if choice.alike:
        own += f"; {', '.join(choice.alike)} give the same bits as one of these"
    if not choice.types:
        return f"{title}: NO CORE TYPES but {own}, no others are known of this processor"
    pairs = zip(choice.types, results, strict=True)
    failed = [core_type for core_type, result in pairs if result.code]
    listed = ", ".join(choice.types)
    verdict = f"FAILED with {', '.join(failed)}" if failed else "passed"
    return f"{title}: core types {listed} {verdict}; all tests ran with {own}"


# Sizes on both sides of the blocks of registers and of caches of the kernels.
SIZES = (1, 2, 3, 5, 7, 8, 9, 12, 15, 16, 17, 24, 31, 33, 48, 63, 64, 65, 100, 129, 200, 257, 400)
# (prefix, suffix, integer) of names: the system's copies, and those in wheels of NumPy and SciPy.
NAMES = (
    ("", "", ctypes.c_int32),
    ("scipy_", "", ctypes.c_int32),
    ("scipy_", "64_", ctypes.c_int64),
    ("", "64_", ctypes.c_int64),
)


class Copy:
    """A copy of OpenBLAS.

    Attributes
    ----------
    address : of a routine: two handles with one address are one copy
    """

    def __init__(self, library: ctypes.CDLL, prefix: str, suffix: str, integer: Any) -> None:
        self.library, self.prefix, self.suffix, self.integer = library, prefix, suffix, integer
        getattr(library, f"{prefix}openblas_get_corename{suffix}")  # other libraries have none
        self.address = ctypes.cast(self._routine("dgemm"), ctypes.c_void_p).value

    def _routine(self, name: str) -> Any:
        return getattr(self.library, f"{self.prefix}{name}_{self.suffix}")

    def call(self, name: str, *arguments: "str | int | float | np.ndarray") -> float:
        """Call a routine with Fortran's conventions; the value of a function of type double."""
        routine = self._routine(name)
        routine.restype = ctypes.c_double
        passed: list[Any] = []
        letters = 0
        for argument in arguments:
            if isinstance(argument, str):
                passed.append(ctypes.c_char_p(argument.encode()))
                letters += 1
            elif isinstance(argument, int):
                passed.append(ctypes.byref(self.integer(argument)))
            elif isinstance(argument, float):
                passed.append(ctypes.byref(ctypes.c_double(argument)))
            else:
                passed.append(argument.ctypes.data_as(ctypes.c_void_p))
        return float(routine(*passed, *[ctypes.c_size_t(1)] * letters))


def copies() -> Iterator[Copy]:
    """Each copy of OpenBLAS that this process has loaded."""
    maps = Path("/proc/self/maps").read_text().splitlines()
    seen = set()
    for file in sorted({line.split(maxsplit=5)[5] for line in maps if "blas" in line.lower()}):
        if ".so" not in file:
            continue
        library = ctypes.CDLL(file)
        for prefix, suffix, integer in NAMES:
            try:
                found = Copy(library, prefix, suffix, integer)
            except AttributeError:
                continue
            if found.address not in seen:
                seen.add(found.address)
                yield found
            break


def rounded(blas: Copy) -> Iterator[np.ndarray]:
    """Results of products, solutions, factors, eigenvalues and singular values of all sizes."""
    random = np.random.default_rng(1)
    for n in SIZES:
        A, B = (np.asfortranarray(random.standard_normal((n, n))) for _ in range(2))
        x, y = random.standard_normal((2, n))
        yield np.array([blas.call("ddot", n, x, 1, y, 1), blas.call("dnrm2", n, x, 1)])
        blas.call("daxpy", n, 0.3, x, 1, y, 1)
        yield y
        for how in "NT":
            z = y.copy()
            blas.call("dgemv", how, n, n, 1.1, A, n, x, 1, 0.7, z, 1)
            yield z
            for other in "NT":
                C = B.copy(order="F")
                blas.call("dgemm", how, other, n, n, n, 1.1, A, n, B, n, 0.7, C, n)
                yield C
            blas.call("dgemm", how, "N", n, min(n, 3), n, 1.0, A, n, B, n, 0.0, C, n)
            yield C
        S = np.zeros((n, n), order="F")
        blas.call("dsyrk", "L", "N", n, n, 1.0, A, n, 0.0, S, n)
        yield S
        z = y.copy()
        blas.call("dsymv", "L", n, 1.0, S, n, x, 1, 0.5, z, 1)
        yield z
        S[np.diag_indices(n)] += 1.0
        L = S.copy(order="F")
        info = np.zeros(1, np.int64)
        blas.call("dpotrf", "L", n, L, n, info)
        yield L
        for side in "LR":
            for how in "NT":
                C = B.copy(order="F")
                blas.call("dtrsm", side, "L", how, "N", n, n, 1.0, L, n, C, n)
                yield C
        z = x.copy()
        blas.call("dtrsv", "L", "N", "N", n, L, n, z, 1)
        yield z
        if n > 129:
            continue
        LU, pivots, C = A.copy(order="F"), np.zeros(n, np.int64), B.copy(order="F")
        blas.call("dgesv", n, n, LU, n, pivots, C, n, info)
        yield C
        work, values, V = np.zeros(64 * (n + 1)), np.zeros(n), S.copy(order="F")
        blas.call("dsyev", "V", "L", n, V, n, values, work, len(work), info)
        yield values
        yield V
        U, singular = A.copy(order="F"), np.zeros(n)
        blas.call("dgesvd", "O", "N", n, n, U, n, singular, V, n, V, n, work, len(work), info)
        yield singular
        yield U


def print_digests(module: str) -> None:
    """Print the digests of all copies that the import of a module loads."""
    importlib.import_module(module)
    for blas in copies():
        digest = hashlib.sha256()
        for array in rounded(blas):
            digest.update(array.tobytes())
        print(digest.hexdigest())


if __name__ == "__main__":
    print_digests(sys.argv[1])
