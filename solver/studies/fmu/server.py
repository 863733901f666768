"""The solver's end of an FMU: answers the library (library.c) over the socket of standard input.

Numbers are of the machine, integers of 32 bits. A request is (what, count) and count doubles:

    START    drive_order, force_order, inputs (k,); the answer has the outputs (n,)
    STEP     time of the end [s], flags, inputs (k,), first and second derivatives of each (k, 2);
             the answer has the time reached [s], whether it is that of an event, the outputs
    SAVE     number of a state to be replaced, or 0; the answer has its number
    RESTORE  number
    FORGET   number
    DERIVE   nothing; the answer has the derivatives (n, k) of the last step

An answer is (status of FMI, length of a text, count), the text and count doubles. Two come without
a request, when the run is ready: (number of inputs, of outputs), and the start of the inputs.
"""

import os
import select
import socket
import struct
import threading
from pathlib import Path

import numpy as np

from ...errors import InputError, PackageError
from ...inputs.common.mesh_files import scripts
from ...math.arrays import Array
from ...run.coupled import Kept, Stepper
from ...run.execution import read_run
from ..sensitivities.differentiated_run import step_derivatives
from .write import INPUTS, derivatives_refused, run_of

OK, WARNING, ERROR = 0, 1, 3
START, STEP, SAVE, RESTORE, FORGET, DERIVE = range(1, 7)
TO_EVENT, JUMPED = 1, 2  # flags of a step
TEXT_BYTES = 4000  # of a message, at most


def main(folder: str) -> int:
    """Serve one instance of the FMU with these resources, until the other end closes."""
    with socket.socket(fileno=os.dup(0)) as channel:
        threading.Thread(target=_end_with, args=(channel,), daemon=True).start()
        try:
            _serve(channel, Path(folder))
        except (BrokenPipeError, ConnectionResetError, EOFError):
            return 0  # the instance is freed
    return 0


def _end_with(channel: socket.socket) -> None:
    """End the process when the importer has ended, in the middle of a step as well."""
    watched = select.poll()
    watched.register(channel, 0)  # poll() always reports a closed channel
    watched.poll()
    os._exit(0)


def _serve(channel: socket.socket, folder: Path) -> None:
    try:
        names = (folder / INPUTS).read_text(encoding="utf-8").splitlines()
        with scripts(allowed=False):
            spec = read_run(run_of(folder))
            stepper = Stepper(spec, names, retraces=True)
    except Exception as error:
        _answer(channel, ERROR, _words(error))
        return
    _answer(channel, OK, "", np.array([len(stepper.inputs), len(stepper.outputs)], dtype=float))
    _answer(channel, OK, "", np.array([given.start[0] for given in stepper.inputs]))
    instance = _Instance(stepper)
    while True:
        what, count = struct.unpack("=ii", _taken(channel, 8))
        numbers = np.frombuffer(_taken(channel, 8 * count))
        try:
            numbers_out = instance.answer(what, numbers)
        except Exception as error:
            _answer(channel, ERROR, _words(error))
            continue
        warnings = "\n".join(stepper.warnings())
        _answer(channel, WARNING if warnings else OK, warnings, numbers_out)


class _Instance:
    """A run and its saved states."""

    def __init__(self, stepper: Stepper) -> None:
        self._stepper, self._states = stepper, dict[int, Kept | None]()
        self._last, self._started = 0, False
        self._refused = derivatives_refused(stepper)

    def answer(self, what: int, numbers: Array) -> Array:
        """Return the numbers of the answer to a request."""
        stepper, k = self._stepper, len(self._stepper.inputs)
        if what == START:
            drive_order, force_order = (int(number) for number in numbers[:2])
            self._started = True
            return stepper.start(numbers[2:], drive_order=drive_order, force_order=force_order)
        if what == STEP:
            t, flags = float(numbers[0]), int(numbers[1])
            if flags & JUMPED:
                stepper.jump()
            inputs, rates = numbers[2 : 2 + k], numbers[2 + k :].reshape(k, 2)
            event = stepper.move(t, inputs, rates, to_event=bool(flags & TO_EVENT))
            return np.array([stepper.t, event, *stepper.measured()])
        if what == DERIVE:
            if self._refused:
                raise InputError(self._refused)
            return step_derivatives(stepper).ravel()
        state = int(numbers[0])
        if what == SAVE:
            if not state:
                self._last = state = self._last + 1
            self._states[state] = stepper.kept() if self._started else None
            return np.array([float(state)])
        if what == FORGET:
            self._states.pop(state, None)
        elif what != RESTORE:
            raise ValueError(f"request {what}: expected {START} to {DERIVE}")
        elif (kept := self._states[state]) is not None:  # else a start, which does everything again
            stepper.restore(kept)
        return np.zeros(0)


def _words(error: Exception) -> str:
    expected = isinstance(error, InputError | PackageError)
    return str(error) if expected else f"{type(error).__name__}: {error}"


def _answer(channel: socket.socket, status: int, text: str, numbers: Array | None = None) -> None:
    data = text.encode("utf-8")[:TEXT_BYTES]
    sent = np.zeros(0) if numbers is None else numbers
    head = struct.pack("=iii", status, len(data), len(sent))
    channel.sendall(head + data + np.ascontiguousarray(sent, dtype=float).tobytes())


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
