"""Two processes that stay for the tests of a session: `mpirun -n 2 python3 pair.py` does scripts, a line of JSON each.

Process 0 reads the lines, and writes what each script has printed, then a line END. Between scripts process 1 looks
at times whether one has come, since waiting for it in MPI would use a core.
"""

import faulthandler
import gc
import json
import signal
import sys
import time
import traceback
from contextlib import redirect_stdout
from io import StringIO

import sheetfx  # noqa: F401  before DOLFINx and PETSc, as the wheel of DOLFINx 0.11 needs

END = "end of the script"


def main() -> None:
    from mpi4py import MPI
    from petsc4py import PETSc

    faulthandler.register(signal.SIGTERM, chain=True)  # where a script is that takes too long
    comm = MPI.COMM_WORLD
    while script := _next_script(comm):
        printed = StringIO()
        try:
            with redirect_stdout(printed):
                exec(compile(script, "script", "exec"), {"__name__": "__main__"})
        except BaseException:
            traceback.print_exc()
            comm.Abort(1)  # the other one may wait for this
        gc.collect()  # on both at once, as MPI wants it
        PETSc.garbage_cleanup()
        comm.barrier()
        if comm.rank == 0:
            print(printed.getvalue() + END, flush=True)


def _next_script(comm) -> str:
    """The next line, on both processes; "": there is none to come."""
    if comm.rank == 0:
        script = json.loads(sys.stdin.readline() or '""')
        comm.send(script, dest=1)
        return script
    while not comm.Iprobe(source=0):
        time.sleep(0.01)
    return comm.recv(source=0)


if __name__ == "__main__":
    main()
