"""Where runs of a study take place: beside each other on this machine, or under mpirun on the other processes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager

from mpi4py import MPI

from .chart import ONE_THREAD

LAUNCHED = "OMPI_COMM_", "OMPI_UNIVERSE_", "PMI_", "PMIX_", "PRTE_", "HYDRA_", "MPI_LOCAL"  # variables of a launcher


@contextmanager
def pool(jobs: int) -> Iterator[Executor | None]:
    """What takes tasks on process 0; None on the others, which have done those that they were sent.

    Parameters
    ----------
    jobs : tasks at a time where there is one process; under mpirun as many as there are further processes
    """
    if MPI.COMM_WORLD.size == 1:
        with ThreadPoolExecutor(jobs) as executor:
            yield executor
        return
    from mpi4py.futures import MPICommExecutor

    with MPICommExecutor(MPI.COMM_WORLD, root=0) as executor:
        yield executor


def alone() -> dict[str, str]:
    """Environment of a program that is one process with one thread, whoever launched this one."""
    return {name: value for name, value in os.environ.items() if not name.startswith(LAUNCHED)} | ONE_THREAD
