"""What the arguments of several subcommands share."""

import argparse
import contextlib
import math
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from ..errors import did_you_mean

# Folder of the results of a command.
FOLDERS = {name: Path("build") / f"{name}s" for name in ("section", "shell", "solid")}

T = TypeVar("T")
COMMAND = "COMMAND"  # what --help and messages call a command
EXECUTORS = ("local", "dask", "mpi")
PROCESSES = ("cores", "cpus", "nproc", "parallel", "processes", "threads", "workers")  # --jobs
EXIT_CODE = "exit code: 0 done; 2 something is wrong with the input."


class HelpText(argparse.RawDescriptionHelpFormatter):
    """Text as wide as the terminal; argparse imports shutil for it, 1 ms of every command."""

    def __init__(self, prog: str) -> None:
        width = os.environ.get("COLUMNS", "")
        columns = int(width) if width.isdecimal() else 0
        with contextlib.suppress(OSError):  # no terminal
            columns = columns or os.get_terminal_size().columns
        super().__init__(prog, width=(columns or 80) - 2)


class CommandParser(argparse.ArgumentParser):
    """A parser that proposes the nearest command or option for one that does not exist."""

    def parsed(self, words: Sequence[str]) -> argparse.Namespace:
        """Parse the words of a command line; what no command knows is an error."""
        folder = ""
        with contextlib.suppress(OSError):  # it may have been removed
            folder = os.getcwd()
        for word in (*words, folder):
            if any("\ud800" <= letter <= "\udfff" for letter in word):
                self.exit(2, f"error: {word!a}: expected a path whose bytes are UTF-8\n")
        options, rest = self.parse_known_args(words)
        if rest:
            chosen = next((self.commands()[w] for w in words if w in self.commands()), self)
            known = chosen._option_string_actions
            unknown = next((word for word in rest if word.startswith("-")), rest[0])
            word = "--jobs" if unknown.strip("-") in PROCESSES else unknown
            # Without the dashes, which make all options alike.
            close = [name for name in known if did_you_mean(word.strip("-"), [name.strip("-")])]
            hint = did_you_mean(word, close) if unknown.startswith("-") else ""
            chosen.error(f"{unknown}: unknown argument{hint}")
        return options

    def error(self, message: str) -> NoReturn:
        """Print usage and message; exit with code 2."""
        _, separator, word = message.partition("invalid choice: ")
        known = sorted(self.commands())
        if known and (separator or message.endswith(COMMAND)):
            if not separator:
                message = "expected CASE.toml or a command"
            elif os.path.exists(word := word.split("'")[1]):
                message = (
                    f"{word}: no case; expected CASE.toml, a folder with case.toml, or a command"
                )
            else:
                what = "file" if os.path.splitext(word)[1] or os.path.dirname(word) else "command"
                file = f"{word}.toml"  # such as `plymotion arm` beside arm.toml
                hint = f"; did you mean {program()} run {file}?" if os.path.isfile(file) else ""
                message = f"{word}: no such {what}{hint or did_you_mean(word, known)}"
            self.exit(2, f"error: {message}\nCommands: {', '.join(known)}\n")
        super().error(message)

    def commands(self) -> dict[str, "CommandParser"]:
        """Return the parsers of the commands by name."""
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                return dict(action.choices)
        return {}


Declare = Callable[[Any], None]  # adds the arguments of a command to its parser, or to a group


def command(name: str, call: str, epilog: str = "") -> Callable[[Declare], Declare]:
    """Return a decorator by which a function that declares arguments adds a whole command.

    Its docstring is the help of the command: a title, what follows the arguments, and above a line
    `---` what precedes them.

    Parameters
    ----------
    call : the function that executes it, `module:name` below this folder; imported for the call
    epilog : more text after the arguments
    """

    def decorated(declare: Declare) -> Declare:
        title, _, text = (declare.__doc__ or "").replace("\n    ", "\n").partition("\n")
        before, _, after = text.rpartition("\n---\n")
        after = after.strip() or epilog
        if "exit code" not in after:
            after = f"{after}\n{EXIT_CODE}".lstrip()

        def add(commands: Any) -> None:
            parser = commands.add_parser(
                name,
                help=title[:1].lower() + title[1:].rstrip("."),
                description=before.strip() or title,
                epilog=after,
                formatter_class=HelpText,
            )
            parser.set_defaults(command=call)
            declare(parser)

        add.__name__ = name
        return add

    return decorated


def flag(group: Any, name: str, help: str) -> None:
    """Add an option without a value to a parser or a group of it.

    Parameters
    ----------
    group : parser, or a group of it
    name : name of the option without dashes
    help : its text
    """
    group.add_argument(f"--{name}", action="store_true", help=help)


def add(group: Any, names: str, metavar: str, help: str, type: Any = Path, **more: Any) -> None:
    """Add an argument with a value to a parser or a group of it; `names` with blanks between.

    Parameters
    ----------
    group : parser, or a group of it
    names : names of the argument, with blanks between
    metavar : name of the value in the help
    help : text of the help
    type : function that reads the value
    more : other options of `add_argument`
    """
    group.add_argument(*names.split(), metavar=metavar, help=help, type=type, **more)


def add_case_options(group: Any) -> None:
    """Add --coarse, --packages and --no-scripts to the arguments of a command with a case."""
    flag(group, "coarse", "apply the [coarse] variant")
    add_packages(group)
    add_no_scripts(group)


def add_packages(group: Any) -> None:
    """Add --packages to the arguments of a command that reads a case."""
    text = "folder of ready packages: none is built, FEniCSx is not needed"
    group.add_argument("--packages", type=Path, metavar="DIR", help=text)


def add_doubtful(parser: Any) -> None:
    """Add --allow-doubtful to the arguments of a command that reads packages."""
    flag(
        parser,
        "allow-doubtful",
        "warn of packages whose numbers contradict each other (see `info`); damaged or "
        "unusable ones are still refused",
    )


def add_no_scripts(group: Any) -> None:
    """Add --no-scripts to the arguments of a command that reads descriptions."""
    flag(
        group,
        "no-scripts",
        "refuse mesh scripts (.geo, .py), which can run any command; see docs/security.md",
    )


def add_report_figures(group: Any) -> None:
    """Add the option that draws the figures of a report as files."""
    flag(
        group,
        "figures",
        "also draw the figures as PNG files, for papers; later commands keep them up to date",
    )
    add_vector_figures(group)


def add_vector_figures(group: Any) -> None:
    """Add the options that draw figures in formats of lines, not pixels."""
    flag(group, "svg", "also draw the figures as SVG files")
    flag(group, "pdf", "also draw the figures as PDF files")


def wanted_formats(options: argparse.Namespace) -> list[str]:
    """Return the formats of figures that the options --figures, --svg and --pdf ask for."""
    wanted = {"png": options.figures, "svg": options.svg, "pdf": options.pdf}
    return [form for form, asked in wanted.items() if asked]


def add_executor(group: Any, what: str) -> None:
    """Add --jobs, --executor and --scheduler to a parser or a group of it; `what` is computed."""
    add(group, "--jobs", "N", f"{what} at a time (default 1)", whole_number)
    group.add_argument(
        "--executor",
        choices=EXECUTORS,
        help="local: processes of this machine (default); dask: workers of a cluster, with "
        "--scheduler; mpi: ranks of an MPI job; see docs/scale.md",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of a dask cluster: its address (tcp://host:8786) or its scheduler file (*.json)",
    )


def program() -> str:
    """Return what the user types for `plymotion`: a path, unless the shell finds it by its name."""
    started = sys.argv[0]
    if os.path.basename(started) != "plymotion" or not os.path.isfile(started):
        return "plymotion"
    import shlex  # these two not for commands that have nothing to propose
    import shutil

    executable = shutil.which("plymotion")
    return (
        "plymotion"
        if executable and os.path.samefile(executable, started)
        else shlex.quote(started)
    )


def whole_number(text: str, least: int = 1) -> int:
    """Read a whole number from `least`; argparse reports anything else."""
    if not text.isdecimal() or int(text) < least:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number from {least}")
    return int(text)


def shard(text: str) -> tuple[int, int]:
    """Read k/N; argparse reports anything else."""
    from ..package.common.plain_data import shard as read  # here, so that --help needs no HDF5

    return read(text)


def number(text: str) -> float:
    """Return the number of a text, nan if it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def numbers(text: str) -> list[float]:
    """Return numbers separated by commas; none at all if one is no finite number."""
    values = [number(part) for part in text.split(",")]
    return values if all(map(math.isfinite, values)) else []


def expecting(
    read: Callable[[str], T], right: Callable[[T], bool], expectation: str
) -> Callable[[str], T]:
    """Return a type of arguments: what `read` makes of the text, an error unless that is right.

    Parameters
    ----------
    read : function that reads the text
    right : whether a value is allowed
    expectation : what is expected, for the message
    """

    def value(text: str) -> T:
        result = read(text)
        if not right(result):
            raise argparse.ArgumentTypeError(f"{text!r}: expected {expectation}")
        return result

    return value
