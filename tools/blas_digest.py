"""A digest of how each copy of OpenBLAS in a process rounds: blas_digest.py MODULE

Imports the module, which loads the copies, and calls the routines that the project relies on, in
each copy, with matrices of many sizes. Prints a digest of all bits of the results of each copy: two
core types with equal digests round alike.
"""

import ctypes
import hashlib
import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

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


def results(blas: Copy) -> Iterator[np.ndarray]:
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


def main(module: str) -> None:
    """Print the digests of all copies that the import of a module loads."""
    importlib.import_module(module)
    for blas in copies():
        digest = hashlib.sha256()
        for array in results(blas):
            digest.update(array.tobytes())
        print(digest.hexdigest())


if __name__ == "__main__":
    main(sys.argv[1])
