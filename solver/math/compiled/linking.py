"""One shared library of the units that processes have used, made by the linker of the system."""

import atexit
import os
import shutil
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path

from .kept import (
    Linked,
    environment,
    folder,
    in_memory,
    kept_library,
    linked,
    read,
    sound,
    symbol_of,
    write,
)
from .parts import Part, digest

MOST_UNITS = 500  # three times those of all methods; then the library begins anew
# All files of an archive. Their code is that of a process: addresses are written into it.
OPTIONS = (
    *("-shared", "-nostartfiles", "-s", "-Wl,-Bsymbolic,-z,notext"),
    *("-Wl,--whole-archive", "/dev/stdin", "-Wl,--no-whole-archive", "-lm"),
)
HEAD = b"%-16s%-12d%-6d%-6d%-8s%-10d`\n"  # of a file in an archive (ar)


others: dict[str, Linked] = {}  # units whose code, or door, this process has from elsewhere


def note_other(part: Part, symbol: str, key: str) -> None:
    """Note object code of a unit or its door that this process has not from the library.

    Parameters
    ----------
    part : part of the unit
    symbol : of the unit
    key : of the file
    """
    if not others:
        atexit.register(link)
    before = others.get(symbol) or linked(symbol)
    files = dict.fromkeys([*(before.files if before else []), key])
    others[symbol] = Linked(part.name, part.content(), [*files])


def link() -> None:
    """Make the library anew if it lacks what this process has used; nothing without a linker.

    One that cannot be linked or loaded is kept as well, so that nobody tries again.
    """
    units, _ = kept_library()
    lacking = [
        symbol
        for symbol, unit in others.items()
        if symbol not in units
        or not sound.get(symbol, True)
        or not {*unit.files} <= {*units[symbol].files}
    ]
    linker, where = shutil.which("cc") or "", folder()
    # not `.` of PATH
    if not lacking or not os.path.isabs(linker) or not where or not os.access(where, os.W_OK):
        return
    if len(units) > MOST_UNITS:
        units = {symbol: unit for symbol, unit in units.items() if sound.get(symbol)}
    for symbol, unit in others.items():
        same = symbol in units and units[symbol].files[0] == unit.files[0]
        files = dict.fromkeys([*unit.files, *(units[symbol].files if same else [])])  # with doors
        units[symbol] = unit._replace(files=[*files])
    codes = {}
    for symbol, unit in units.items():
        pieces = [piece for key in unit.files if (piece := read(key)) is not None]
        if len(pieces) == len(unit.files):
            own, _ = pieces[0]
            needs = {symbol_of(name, text): result for name, text, result in own["units"]}
            units[symbol] = unit._replace(result=own["result"], needs=needs)
            codes[symbol] = b"".join(_member(code) for _, code in pieces)
    while lost := [one for one in codes if not units[one].needs.keys() <= codes.keys()]:
        for symbol in lost:
            del codes[symbol]
    description = {"name": "library", "units": {symbol: units[symbol] for symbol in codes}}
    code = _shared_library(linker, where, b"".join(codes.values()))
    write(digest("library", environment()), description, code)


def _member(code: bytes) -> bytes:
    return HEAD % (b"unit.o/", 0, 0, 0, b"644", len(code)) + code + b"\n" * (len(code) % 2)


def _shared_library(linker: str, where: Path, members: bytes) -> bytes:
    """Return the shared library of an archive's members; nothing if the linker refuses.

    Parameters
    ----------
    linker : path of the program
    where : folder for the file of the linker. If this process is killed, that is left under a name
        by which the cache knows temporary files
    members : content of the archive
    """
    made = None
    try:
        handle, made = tempfile.mkstemp(dir=where, prefix=".new-")
        os.close(handle)
        with in_memory(b"!<arch>\n" + members) as archive:
            command, silent = [linker, *OPTIONS, "-o", made], subprocess.DEVNULL
            subprocess.run(
                command, check=True, stdin=archive, stdout=silent, stderr=silent, timeout=60.0
            )
        return Path(made).read_bytes()
    except (OSError, subprocess.SubprocessError):
        return b""
    finally:
        with suppress(OSError):
            os.unlink(made or "")
