"""Calls a function in a fork of this process, whatever happens there."""
import faulthandler
import json
import os
import resource
import select
import signal
from typing import Any, Callable, Dict, Iterable, Iterator, Tuple

MEMORY = 1 << 30
SECONDS = 60


def outcomes(
    function: Callable[[Any], Any],
    inputs: Iterable[Any],
    at_once: int = 2,
    seconds: int = SECONDS,
    memory: int = MEMORY,
) -> Iterator[Tuple[Any, Any]]:
    """(input, what the function returned as JSON has it, or the name of the signal that ended it).

    Each in a process of its own that may take so much memory and time, some of them at once.
    """
    running: Dict[int, Tuple[Any, int, bytearray]] = {}
    todo, more = iter(inputs), True
    while more or running:
        while more and len(running) < at_once:
            try:
                value = next(todo)
            except StopIteration:
                more = False
                break
            pid, reading = _fork(function, value, seconds, memory)
            running[reading] = (value, pid, bytearray())
        for reading in select.select(list(running), [], [])[0] if running else ():
            data = os.read(reading, 1 << 16)
            value, pid, said = running[reading]
            said += data
            if data:
                continue
            del running[reading]
            os.close(reading)
            state = os.waitpid(pid, 0)[1]
            if os.WIFSIGNALED(state):
                yield value, signal.Signals(os.WTERMSIG(state)).name
            else:
                yield value, json.loads(said.decode()) if said else "exit %d" % (state >> 8)


def _fork(function, value, seconds, memory):
    reading, writing = os.pipe()
    pid = os.fork()
    if pid:
        os.close(writing)
        return pid, reading
    try:
        faulthandler.disable()  # pytest's
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what the C library says of its own heap
        with open("/proc/self/statm", "rb") as stream:
            memory += int(stream.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(seconds)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        result = function(value)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
        os.write(writing, json.dumps([result, peak << 10]).encode())
    finally:
        os._exit(0)
