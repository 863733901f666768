"""The solver's end of an FMU: answers the library (library.c) over the socket of standard input.

Numbers are of the machine, integers of 32 bits. A request is (what, count) and count doubles:

    START   drive_order, force_order, inputs (k,)
    STEP    time of the end [s], inputs (k,), first and second derivatives of each (k, 2)

An answer is (status of FMI, length of a text, count), the text and count doubles. Two come without
a request, when the run is ready: (number of inputs, of outputs), and the start of the inputs. All
others have the outputs.
"""

import os
import socket
import struct
from pathlib import Path

import numpy as np

from ...errors import InputError, PackageError
from ...inputs.common.mesh_files import scripts
from ...math.arrays import Array
from ...run.coupled import Stepper
from ...run.execution import read_run
from .write import INPUTS, run_of

OK, WARNING, ERROR = 0, 1, 3
START, STEP = 1, 2
TEXT_BYTES = 4000  # of a message, at most


def main(folder: str) -> int:
    """Serve one instance of the FMU with these resources, until the other end closes."""
    with socket.socket(fileno=os.dup(0)) as channel:
        try:
            _serve(channel, Path(folder))
        except (BrokenPipeError, ConnectionResetError, EOFError):
            return 0  # the instance is freed
    return 0


def _serve(channel: socket.socket, folder: Path) -> None:
    try:
        names = (folder / INPUTS).read_text(encoding="utf-8").splitlines()
        with scripts(allowed=False):
            stepper = Stepper(read_run(run_of(folder)), names)
    except Exception as error:
        _answer(channel, ERROR, _words(error))
        return
    _answer(channel, OK, "", np.array([len(stepper.inputs), len(stepper.outputs)], dtype=float))
    _answer(channel, OK, "", np.array([given.start[0] for given in stepper.inputs]))
    while True:
        what, count = struct.unpack("=ii", _taken(channel, 8))
        numbers = np.frombuffer(_taken(channel, 8 * count))
        try:
            outputs = _started(stepper, numbers) if what == START else _moved(stepper, numbers)
        except Exception as error:
            _answer(channel, ERROR, _words(error))
            continue
        told = "\n".join(stepper.warnings())
        _answer(channel, WARNING if told else OK, told, outputs)


def _started(stepper: Stepper, numbers: Array) -> Array:
    drive_order, force_order = (int(number) for number in numbers[:2])
    return stepper.start(numbers[2:], drive_order=drive_order, force_order=force_order)


def _moved(stepper: Stepper, numbers: Array) -> Array:
    k = len(stepper.inputs)
    return stepper.advance(float(numbers[0]), numbers[1 : 1 + k], numbers[1 + k :].reshape(k, 2))


def _words(error: Exception) -> str:
    expected = isinstance(error, InputError | PackageError)
    return str(error) if expected else f"{type(error).__name__}: {error}"


def _answer(channel: socket.socket, status: int, text: str, numbers: Array | None = None) -> None:
    data = text.encode("utf-8")[:TEXT_BYTES]
    found = np.zeros(0) if numbers is None else numbers
    head = struct.pack("=iii", status, len(data), len(found))
    channel.sendall(head + data + np.ascontiguousarray(found, dtype=float).tobytes())


def _taken(channel: socket.socket, size: int) -> bytes:
    """Return `size` bytes. Raises EOFError at the end of the conversation."""
    parts: list[bytes] = []
    while size > 0:
        part = channel.recv(min(size, 1 << 20))
        if not part:
            raise EOFError
        parts.append(part)
        size -= len(part)
    return b"".join(parts)
