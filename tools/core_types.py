"""Run some tests with every kernel of OpenBLAS that this processor has.

OpenBLAS chooses its kernels by the type of the processor's cores, and rounds differently with
each; OPENBLAS_CORETYPE chooses another one. A test whose verdict changes with it compares
rounding with rounding.
"""

import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

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
    rounding : digests of results (blas_digest.py); types with equal ones round alike. The names,
        if they could not be computed
    """

    names: frozenset[str]
    rounding: frozenset[str]


def kernels(tests: Tests, core_type: str) -> Kernels:
    """The kernels that tests use with a core type; the processor's own with an empty name."""
    done = subprocess.run(
        [tests.python, str(Path(__file__).with_name("blas_digest.py")), tests.loads],
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
