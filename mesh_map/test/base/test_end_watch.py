"""A process that is told to end does so, whatever keeps it from that."""

import signal
import subprocess
import sys

import pytest

PROGRAM = """
import ctypes, signal, sys, threading, time
from mesh_map.base.end_watch import end_when_told

for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda number, _frame: {handler})
end_when_told({seconds})

def holds_the_lock():
    print("ready", flush=True)
    ctypes.PyDLL(None).pause()  # unlike CDLL, it keeps the lock; no signal is for this thread
    ctypes.PyDLL(None).sleep(600)

def computes():
    print("ready", flush=True)
    while True:
        pass

def starts_nothing():
    print("ready", flush=True)
    time.sleep(600)

{what}
"""
IN_A_THREAD = "thread = threading.Thread(target=%s)\nthread.start()\nthread.join()"
SAID = "error: something, perhaps a plugin, has kept process %d for 0.2 s from its end on signal %d"


def ended(number, **fields):
    """(process, what it said on stderr) of a program that was told to end when it was ready."""
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM.format(**{"seconds": 0.2, "handler": "None", **fields})],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
    )
    try:
        assert process.stdout.readline() == "ready\n"
        process.send_signal(number)
        return process, process.communicate(timeout=60)[1]
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    "what", ["computes()", IN_A_THREAD % "computes", IN_A_THREAD % "holds_the_lock"]
)
def test_what_hangs_is_ended(number, what):
    process, said = ended(number, what=what)
    assert process.returncode == 128 + number
    assert said.startswith(SAID % (process.pid, number)) and said.count("\n") == 1


def test_what_ends_by_itself_does_so():
    process, said = ended(
        signal.SIGTERM, what="starts_nothing()", handler="sys.exit(3)", seconds=600
    )
    assert (process.returncode, said) == (3, "")


def test_other_signals_end_nothing():
    what = "signal.signal(signal.SIGUSR1, lambda *_: sys.exit(4))\nend_when_told(0)\ncomputes()"
    assert ended(signal.SIGUSR1, what=what)[0].returncode == 4
