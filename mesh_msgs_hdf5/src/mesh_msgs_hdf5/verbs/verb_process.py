"""A verb of another package in a process of its own: if its code crashes, mesh_tool says so."""
import ctypes
import json
import os
import signal
import subprocess
import sys
from typing import Any, List, Optional, Tuple

from mesh_msgs_hdf5 import __path__ as package_folders
from mesh_msgs_hdf5.verbs.exported_verb import ExportedVerb

# -I: not the modules of the current folder, but those of mesh_tool
_PROGRAM = """
import json, signal, sys
signal.signal(signal.SIGINT, signal.SIG_DFL)
sys.path[:] = json.loads(sys.argv[1])
from mesh_msgs_hdf5.commands.mesh_tool import run_exported
sys.exit(run_exported(*json.loads(sys.argv[2])))
"""
_PR_SET_PDEATHSIG = 1
_SIGNALED = 128  # and the number of the signal: the exit code that shells give


def run_verb(verb: ExportedVerb, arguments: List[str]) -> Tuple[int, str]:
    """Run a verb with its arguments until it ends.

    Returns its exit code, and where a signal has ended it a line that says so.

    Ctrl+C, and SIGINT sent to this process alone, reach it once; a second one ends it at once. So
    does SIGTERM, which it may take as a reason to save what it has. It ends with this process,
    however that ends. Raises KeyboardInterrupt where SIGINT has ended it.
    """
    process: Optional[subprocess.Popen] = None
    interrupts = 0
    terminated = False

    def interrupt(*_: Any) -> None:
        nonlocal interrupts
        interrupts += 1
        if process is not None:
            process.send_signal(signal.SIGINT if interrupts == 1 else signal.SIGKILL)

    def terminate(*_: Any) -> None:
        nonlocal terminated
        terminated = True
        if process is not None:
            process.send_signal(signal.SIGTERM)

    before = signal.signal(signal.SIGINT, interrupt)
    before_term = signal.signal(signal.SIGTERM, terminate)
    try:
        process = subprocess.Popen(_command(verb, arguments))
        if interrupts:  # before it was there
            process.send_signal(signal.SIGINT)
        if terminated:
            process.send_signal(signal.SIGTERM)
        code = process.wait()
    finally:
        signal.signal(signal.SIGINT, before)
        signal.signal(signal.SIGTERM, before_term)
        if process is not None and process.poll() is None:
            process.kill()
            process.wait()
    if terminated and code == -signal.SIGTERM:
        os.kill(os.getpid(), signal.SIGTERM)  # whoever has sent it sees that it was obeyed
    if interrupts and code < 0:
        raise KeyboardInterrupt
    return (code, "") if code >= 0 else (_SIGNALED - code, _crash(verb, -code))


def _crash(verb: ExportedVerb, number: int) -> str:
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = "signal %d" % number
    if number == signal.SIGKILL:
        name += "; was there enough memory?"
    return "verb %s of package %s crashed: %s" % (verb.name, verb.package, name)


def _command(verb: ExportedVerb, arguments: List[str]) -> List[str]:
    # first where this package is: in a devel space of catkin its compiled module is elsewhere
    own = [os.path.dirname(folder) for folder in package_folders]
    search = json.dumps(own + [place for place in sys.path if place])
    call = json.dumps([list(verb), arguments, os.getpid()])
    return [sys.executable or "/usr/bin/python3", "-I", "-c", _PROGRAM, search, call]


def prepare_process(parent: int) -> None:
    """In the process of a verb: it ends with mesh_tool, and is interrupted once."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != parent:
        os._exit(1)

    def interrupt(*_: Any) -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # it comes from the terminal and mesh_tool
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)
