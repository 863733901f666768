"""Machine code in the user's cache: a file for each unit, and one shared library of all of them.

The library is loaded without LLVM, whose import takes 30 ms. A process that finds a unit missing in
it takes the file, or compiles, and links the library anew when it ends.
"""

import ctypes
import json
import os
import sys
from collections.abc import Mapping
from functools import cache
from io import FileIO
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

from ..disk_cache import DiskCache, sources_sha256
from .parts import digest, installed_version, part_named, statistics

MOST_FILES = 2000  # of about 20 kB
_CODE = DiskCache("code", MOST_FILES)


@cache
def environment() -> str:
    """Return the digest of what all functions are compiled by and for."""
    settings = sorted(f"{k}={v}" for k, v in os.environ.items() if k.startswith("NUMBA_"))
    return digest(
        installed_version("numba"),
        installed_version("llvmlite"),
        sys.version,
        *_processor(),
        *settings,
        sources_sha256("solver/math/compiled", apart=("solver/math/compiled/README.md",)),
    )


CPUINFO = "/proc/cpuinfo"
# What a processor of x86 is and can do; LLVM chooses instructions by nothing else. Lines of
# frequencies and of cores differ between machines of one kind, or from time to time.
_TELLING = ("vendor_id", "cpu family", "model", "stepping", "flags")


def _processor() -> list[str]:
    """Return the lines of the kernel about the first processor; LLVM's words without them."""
    try:
        with open(CPUINFO, encoding="utf-8", errors="replace") as file:
            first = takewhile(str.strip, file)  # up to an empty line
            lines = [line for line in first if line.startswith(_TELLING)]
    except OSError:
        lines = []
    if any(line.startswith("flags") for line in lines):
        return lines
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features().flatten()
    return [llvm.get_default_triple(), llvm.get_host_cpu_name(), features]


def folder() -> Path | None:
    """Return the folder of compiled code, made if missing; None if that is not possible."""
    return _CODE.made()


def read(key: str) -> tuple[dict[str, Any], bytes] | None:
    """Return the description and the object code kept under `key`; None if there is none."""
    content = _CODE.read(key)
    if content is None:
        return None
    head, _, code = content.partition(b"\n")
    return json.loads(head), code


def write(key: str, description: Mapping[str, object], code: bytes) -> bool:
    """Keep object code; return whether that was possible.

    Parameters
    ----------
    key : digest of all that it depends on
    description : plain data
    code : object code
    """
    return _CODE.write(key, json.dumps(description).encode() + b"\n" + code)


def noted(*texts: str) -> bool:
    """Return whether `note` was called with the same texts, in this environment."""
    return read(digest(*texts, environment())) is not None


def note(name: str, *texts: str) -> None:
    """Keep a note that has no code, under texts and the environment."""
    write(digest(name, *texts, environment()), {"name": name}, b"")


def symbol_of(name: str, text: str) -> str:
    """Return the symbol of the unit of a part, by its name, for argument types."""
    return f"plymotion_{digest(name, text)}"


def door_key(symbol: str, result: str) -> str:
    """Return the key of the way from Python to a unit, by its symbol and the type of its result."""
    return digest("door", symbol, result, environment())


def in_memory(content: bytes = b"") -> FileIO:
    """Return a file that has no name and ends with the last process that has it open."""
    file = FileIO(os.memfd_create("plymotion"), "r+")
    file.write(content)
    return file


class Linked(NamedTuple):
    """A unit in the library."""

    name: str  # of its part
    content: str  # digest of its part
    key: str  # of the file of its object code
    door: bool  # whether Python can call it
    result: str = ""  # type
    needs: Mapping[str, str] = {}  # units that it calls: types of their results, by symbol


sound: dict[str, bool] = {}  # whether a unit of the library is what this process would compile


def kept_library() -> tuple[dict[str, Linked], bytes]:
    """Return the units of the library as it is now, by symbol, and its content."""
    description, code = read(digest("library", environment())) or ({"units": {}}, b"")
    return {symbol: Linked(*fields) for symbol, fields in description["units"].items()}, code


@cache
def _library() -> tuple[dict[str, Linked], Any]:
    """Return the units of the library by symbol, and the library; None if it cannot be loaded."""
    units, code = kept_library()
    try:
        # not the file: that has a checksum, and may lie where no code is executed
        with in_memory(code) as file:
            place = f"/proc/self/fd/{file.fileno()}"
            # global: units that LLVM loads find those of the library
            return units, ctypes.CDLL(place, mode=ctypes.RTLD_GLOBAL)
    except (OSError, AttributeError):
        return units, None


def linked(symbol: str) -> Linked | None:
    """Return a unit of the library; None if there is none, or its part or a callee was edited."""
    units, library = _library()
    if library is None or symbol not in units:
        return None
    unit = units[symbol]
    if symbol not in sound:
        part = part_named(unit.name)
        sound[symbol] = (
            part is not None
            and part.content() == unit.content
            and all(
                (callee := linked(one)) is not None and callee.result == result
                for one, result in unit.needs.items()
            )
        )
        if sound[symbol]:
            statistics.loaded.append(unit.name)
    return unit if sound[symbol] else None


def address_in_library(symbol: str) -> int | None:
    """Return the address of a symbol of the library; None if there is none."""
    try:
        return ctypes.cast(_library()[1][symbol], ctypes.c_void_p).value
    except (AttributeError, TypeError):
        return None
