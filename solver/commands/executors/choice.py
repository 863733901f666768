"""The executor that options choose."""

import argparse
from typing import TYPE_CHECKING

from ...errors import InputError

if TYPE_CHECKING:
    from .executor import Executor


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
