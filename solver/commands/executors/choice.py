"""The options that choose an executor."""

import argparse
from typing import TYPE_CHECKING, Any

from ...errors import InputError
from ..arguments import whole_number

if TYPE_CHECKING:
    from .executor import Executor

KINDS = ("local", "dask", "mpi")


def add_executor(group: Any, what: str) -> None:
    """Add --jobs, --executor and --scheduler to a parser or a group of it; `what` is computed."""
    group.add_argument(
        "--jobs", type=whole_number, metavar="N", help=f"{what} at a time (default 1)"
    )
    group.add_argument(
        "--executor",
        choices=KINDS,
        help="local: processes of this machine (default); dask: workers of a cluster, with "
        "--scheduler; mpi: ranks of an MPI job; see docs/scale.md",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of a dask cluster: its address (tcp://host:8786) or its scheduler file (*.json)",
    )


def executor_of(options: argparse.Namespace, *, threads: bool = False) -> "Executor":
    """Return the executor that the options ask for.

    Parameters
    ----------
    threads : tasks do no work in this process themselves, so threads of it are enough

    Raises
    ------
    InputError
        Options that contradict each other, or an executor that is not there.
    """
    kind = options.executor or ("dask" if options.scheduler else "local")
    if options.scheduler and kind != "dask":
        raise InputError(f"--scheduler {options.scheduler}: expected with --executor dask only")
    if kind != "local" and options.jobs:
        raise InputError(f"--jobs {options.jobs}: expected with --executor local only")
    if kind == "dask":
        if not options.scheduler:
            raise InputError("--executor dask: expected --scheduler ADDRESS or FILE.json as well")
        from .dask import Dask

        return Dask(options.scheduler)
    if kind == "mpi":
        from .mpi import Mpi

        return Mpi()
    from .local import Here, Local

    jobs = options.jobs or 1
    return Here() if jobs == 1 and not threads else Local(jobs, threads=threads)
