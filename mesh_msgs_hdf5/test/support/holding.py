"""Another program that has a map file open to write."""
import contextlib
import subprocess
import sys

_PROGRAM = """
import sys, h5py
with h5py.File(sys.argv[1], "r+") as file:
    print("open", flush=True)
    sys.stdin.read()
"""


@contextlib.contextmanager
def held_open(path):
    """Within it a process of its own has the file open with h5py, locked as HDF5 does it."""
    command = [sys.executable, "-c", _PROGRAM, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"open\n"
        yield process
        process.stdin.close()
        process.wait(60)
