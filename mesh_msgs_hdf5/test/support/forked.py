"""Calls a function in forks of this process, whatever happens there."""
import collections
import faulthandler
import json
import os
import resource
import select
import signal
from typing import Any, Callable, Deque, Dict, Iterable, Iterator, List, Tuple

MEMORY = 1 << 30
SECONDS = 60


def outcomes(
    function: Callable[[Any], Any],
    inputs: Iterable[Any],
    at_once: int = 2,
    seconds: int = SECONDS,
    memory: int = MEMORY,
    batch: int = 1,
) -> Iterator[Tuple[Any, Any]]:
    """(input, [what the function returned as JSON has it, how far the memory's peak rose]).

    In place of the latter the name of the signal that ended it. So many inputs in a row share a
    process, and some processes run at once; each input may take so much memory and time. What ends
    a process that dealt with others before has another one, as its first, before that counts.
    """
    everything = list(inputs)
    todo: Deque[List[Any]] = collections.deque(
        everything[start : start + batch] for start in range(0, len(everything), batch)
    )
    running: Dict[int, Tuple[List[Any], int, bytearray]] = {}
    while todo or running:
        while todo and len(running) < at_once:
            values = todo.popleft()
            pid, reading = _fork(function, values, seconds, memory)
            running[reading] = (values, pid, bytearray())
        for reading in select.select(list(running), [], [])[0]:
            data = os.read(reading, 1 << 16)
            values, pid, said = running[reading]
            said += data
            if data:
                continue
            del running[reading]
            os.close(reading)
            state = os.waitpid(pid, 0)[1]
            answers = said.decode().split("\n")[:-1]
            yield from zip(values, map(json.loads, answers))
            rest = values[len(answers) :]
            if rest and not answers:
                yield rest.pop(0), _end(state)
            if rest:
                todo.appendleft(rest)


def _end(state):
    if os.WIFSIGNALED(state):
        return signal.Signals(os.WTERMSIG(state)).name
    return "exit %d" % (state >> 8)


def _fork(function, values, seconds, memory):
    reading, writing = os.pipe()
    pid = os.fork()
    if pid:
        os.close(writing)
        return pid, reading
    try:
        faulthandler.disable()  # pytest's
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what the C library says of its own heap
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        for value in values:
            _limit(resource.RLIMIT_AS, memory)
            signal.alarm(seconds)
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            result = function(value)
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
            os.write(writing, json.dumps([result, peak << 10]).encode() + b"\n")
    finally:
        os._exit(0)


def _limit(kind, more):
    """This process may take so much more than it has."""
    with open("/proc/self/statm", "rb") as stream:
        has = int(stream.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(kind, (has + more, resource.getrlimit(kind)[1]))
