"""One shared library of the units that processes have used, made by the linker of the system."""

import atexit
import os
import shutil
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path

from .parts import Part, digest
from .unit_files import (
    Linked,
    door_key,
    environment,
    folder,
    in_memory,
    kept_library,
    read,
    sound,
    symbol_of,
    write,
)

MOST_UNITS = 500  # three times those of all methods; then the library begins anew
# All files of an archive. Their code is that of a process: addresses are written into it.
OPTIONS = (
    *("-shared", "-nostartfiles", "-s", "-Wl,-Bsymbolic,-z,notext"),
    *("-Wl,--whole-archive", "/dev/stdin", "-Wl,--no-whole-archive", "-lm"),
)
HEAD = b"%-16s%-12d%-6d%-6d%-8s%-10d`\n"  # of a file in an archive (ar)


others: dict[str, Linked] = {}  # units whose code, or door, this process has from elsewhere


def note_other(part: Part, symbol: str, key: str, *, door: bool = False) -> None:
    """Note a unit that this process has not from the library.

    Parameters
    ----------
    part : part of the unit
    symbol : of the unit
    key : of its file
    door : whether it was called from Python, and that way is not from the library
    """
    if not others:
        atexit.register(link)
    others[symbol] = Linked(part.name, part.content(), key, door)


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
        or unit.key != units[symbol].key
        or (unit.door and not units[symbol].door)
    ]
    linker, where = shutil.which("cc") or "", folder()
    # not `.` of PATH
    if not lacking or not os.path.isabs(linker) or not where or not os.access(where, os.W_OK):
        return
    if len(units) > MOST_UNITS:
        units = {symbol: unit for symbol, unit in units.items() if sound.get(symbol)}
    codes = {}
    for symbol, unit in (units | others).items():
        kept = read(unit.key)
        if kept is not None:
            own, code = kept
            door = read(door_key(symbol, own["result"]))
            needs = {symbol_of(name, text): result for name, text, result in own["units"]}
            units[symbol] = unit._replace(door=bool(door), result=own["result"], needs=needs)
            codes[symbol] = _member(code) + (_member(door[1]) if door else b"")
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
