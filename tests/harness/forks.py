"""Commands in forks of one process that has loaded the program: processes without its start.

A command takes 0.4 s to load its modules, which is more than it takes to do what the tests ask for.
A fork has a number, a memory, signals, limits and an exit code of its own, and ends as an
interpreter does. What happens while modules are loaded is tested in processes that load them.
Compiled loops are off, unless the environment of a fork says otherwise.
"""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
from typing import Any

# Each order has the code, its arguments, environment and folder; with it come standard output,
# standard error and a pipe, which gets the number of the process, and its exit code when it ends.
SERVER = """
import atexit, gc, json, os, signal, socket, sys
for module in json.loads(sys.argv[2]):
    __import__(module)
gc.collect()
gc.freeze()
gc.set_threshold(50_000)
atexit.register(gc.freeze)
orders = socket.socket(fileno=int(sys.argv[1]))
running = set()
while True:
    text, files, _, _ = socket.recv_fds(orders, 1 << 20, 3)
    if not text:
        break
    watcher = os.fork()
    if watcher:
        for file in files:
            os.close(file)
        running = {pid for pid in running | {watcher} if not os.waitpid(pid, os.WNOHANG)[0]}
        continue
    orders.close()
    child = os.fork()
    if child:
        os.close(files[0]), os.close(files[1])
        os.write(files[2], b"%d\\n" % child)
        os.write(files[2], b"%d\\n" % os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
        os._exit(0)
    order = json.loads(text)
    os.setsid()
    os.dup2(files[0], 1), os.dup2(files[1], 2)
    for file in files:
        os.close(file)
    os.chdir(order["folder"])
    os.environ.clear()
    os.environ.update(order["environment"])
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        usual = signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL
        ignored = name in order["ignored"]
        signal.signal(getattr(signal, name), signal.SIG_IGN if ignored else usual)
    sys.argv = ["-c", *order["words"]]
    exec(compile(order["code"], "<string>", "exec"), {"__name__": "__main__"})
    sys.exit()
for pid in running:
    os.waitpid(pid, 0)
"""
MODULES = [
    *("numpy.ma", "h5py", "concurrent.futures.process", "matplotlib.backends.backend_agg"),
    *("plymotion.solver.__main__", "plymotion.solver.run.execution"),
    *("plymotion.solver.inputs.case.load", "plymotion.solver.inputs.case.write"),
    *("plymotion.solver.studies.runs", "plymotion.solver.commands.sweep"),
    *("plymotion.solver.studies.sweep.portions", "plymotion.solver.studies.sweep.sweep_outcome"),
    "plymotion.solver.report.report_page",
]
OFF = {"PLYMOTION_COMPILED": "0"}


class Fork:
    """A process that `Forks` has started; as subprocess.Popen with pipes of text."""

    def __init__(self, words: list[str], out: int, errors: int, status: int) -> None:
        self.args = words
        self.returncode: int | None = None
        self.stdout = open(out, encoding="utf-8")  # noqa: SIM115  as long as the process
        self._errors = open(errors, encoding="utf-8")  # noqa: SIM115
        self._status = open(status, encoding="utf-8")  # noqa: SIM115
        self.pid = int(self._status.readline())
        self._told: list[str] = []
        self._reader = threading.Thread(target=lambda: self._told.append(self._errors.read()))
        self._reader.start()

    def send_signal(self, number: int) -> None:
        """Send a signal to the process."""
        os.kill(self.pid, number)

    def kill(self) -> None:
        """Kill the process, unless it has ended."""
        if self.returncode is None:
            self.send_signal(signal.SIGKILL)

    def communicate(self, timeout: float) -> tuple[str, str]:
        """Wait for the end of the process; return its output and errors."""
        alarm = threading.Timer(timeout, self.kill)
        alarm.start()
        out = self.stdout.read()
        self.returncode = int(self._status.readline())
        alarm.cancel()
        self._reader.join()
        for file in (self.stdout, self._errors, self._status):
            file.close()
        return out, self._told[0]


class Forks:
    """The process of SERVER, which loads modules; it is started when it is asked for first."""

    def __init__(self, modules: list[str]) -> None:
        self._modules = modules
        self._server: subprocess.Popen[bytes] | None = None
        self._orders: socket.socket | None = None

    def started(self, code: str, *words: str, **environment: str) -> Fork:
        """Start code with arguments; `environment` is added to that of this process."""
        if self._orders is None:
            self._orders, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            modules = json.dumps(self._modules)
            command = [sys.executable, "-c", SERVER, str(theirs.fileno()), modules]
            self._server = subprocess.Popen(
                command, pass_fds=[theirs.fileno()], env=os.environ | OFF, stdin=subprocess.DEVNULL
            )
            theirs.close()
        names = ("SIGINT", "SIGTERM", "SIGHUP")
        order: dict[str, Any] = {
            "code": code,
            "words": words,
            "environment": os.environ | OFF | environment,
            "folder": os.getcwd(),
            "ignored": [n for n in names if signal.getsignal(getattr(signal, n)) is signal.SIG_IGN],
        }
        pipes = [os.pipe() for _ in range(3)]
        theirs_of = [write for _, write in pipes]
        socket.send_fds(self._orders, [json.dumps(order).encode()], theirs_of)
        for file in theirs_of:
            os.close(file)
        return Fork([code, *words], *(read for read, _ in pipes))

    def run(
        self, code: str, *words: str, timeout: float = 600.0, **environment: str
    ) -> "subprocess.CompletedProcess[str]":
        """Run code with arguments, as `subprocess.run` does."""
        process = self.started(code, *words, **environment)
        out, errors = process.communicate(timeout)
        return subprocess.CompletedProcess(process.args, process.returncode or 0, out, errors)

    def end(self) -> None:
        """End the server; its processor time belongs to the tests."""
        if self._orders is not None and self._server is not None:
            self._orders.close()
            self._server.wait(timeout=60)
        self._server = self._orders = None


forks = Forks(MODULES)
