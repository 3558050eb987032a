"""The zygote's program: waits for requests, forks a process for each and says how it ended."""
import array
import contextlib
import ctypes
import gc
import importlib
import os
import resource
import select
import signal
import socket
import traceback
import warnings
from typing import Any, Dict, NoReturn

import h5py
import numpy as np

import mesh_msgs_hdf5.isolation.isolated_calls  # noqa: F401 (loads all that is needed once for all)
from mesh_msgs_hdf5.isolation.wire import MOST_SHARED, Wire, WireError
from mesh_msgs_hdf5.isolation.zygote import OUT_OF_MEMORY
from mesh_msgs_hdf5.model.errors import MapFileError

_LIBC = ctypes.CDLL(None)
_PR_SET_PDEATHSIG = 1
_LOOK_SECONDS = 5
_ANY_SIZE = 1 << 48


def serve(number: int) -> NoReturn:
    """Fork a process for each request on the socket with this number, until it closes.

    A request is the memory limit, two sockets and a file in memory: the new process answers on the
    first socket, large arrays in the file; the second is told its exit status, and when the other
    end of that closes, it is killed.
    """
    parent = os.getppid()
    control = socket.socket(fileno=number)
    wake, waker = socket.socketpair()
    waker.setblocking(False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(waker.fileno(), warn_on_full_buffer=False)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _warm_up()
    gc.collect()
    gc.freeze()  # so that the collector touches no page that is shared
    children: Dict[socket.socket, int] = {}
    while os.getppid() == parent:  # who has forked too may keep the socket open
        ready, _, _ = select.select([control, wake, *children], [], [], _LOOK_SECONDS)
        if control in ready and not _take_request(control, children, (wake, waker)):
            break
        if wake in ready:
            wake.recv(4096)
        for status in set(ready) & set(children):
            with status:  # nobody waits for it any more; its id is its own until it is reaped
                os.kill(children.pop(status), signal.SIGKILL)
        _reap(children)
    os._exit(0)  # and with it all children, see _die_with


def _warm_up():
    """Have HDF5 set up what it sets up at its first use, once for all that are forked."""
    with h5py.File("warm_up", "w", driver="core", backing_store=False) as file:
        file["numbers"] = np.zeros(3, np.float32)
        file["numbers"][()]


def _take_request(control, children, own):
    """Fork for the next request; False if there will be none."""
    size = socket.CMSG_SPACE(3 * array.array("i").itemsize)
    message, passed, _, _ = control.recvmsg(64, size, socket.MSG_CMSG_CLOEXEC)
    numbers = array.array("i")
    for _, _, data in passed:
        numbers.frombytes(data)
    if not message or len(numbers) != 3:
        return False
    connection, status = (socket.socket(fileno=number) for number in numbers[:2])
    zygote = os.getpid()
    with connection, os.fdopen(numbers[2], "r+b", buffering=0) as shared:
        try:
            pid = os.fork()
        except OSError:  # too many processes: whoever asks is told by the closed connection
            status.close()
            return True
        if not pid:
            signal.set_wakeup_fd(-1)
            for other in (control, status, *own, *children):
                other.close()
            _run(Wire(connection, shared=shared.fileno()), int(message), zygote)
        children[status] = pid
    return True


def _reap(children):
    """Take leave of those that have ended, and say how to who waits for it."""
    while True:
        try:
            pid, state = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return
        if not pid:
            return
        code = -os.WTERMSIG(state) if os.WIFSIGNALED(state) else os.WEXITSTATUS(state)
        for status in [one for one, its in children.items() if its == pid]:
            del children[status]
            with status, contextlib.suppress(OSError):
                status.sendall(b"%d" % code)


def _run(wire, memory_limit, zygote) -> NoReturn:
    """The forked process: an answer to each request, until the connection closes."""
    code = 1
    try:
        _die_with(zygote)
        _limit(memory_limit)
        while True:
            _take_part(wire)
    except MemoryError:  # not even enough to say so
        code = OUT_OF_MEMORY
    except (EOFError, OSError):
        pass  # who has asked is gone
    finally:
        os._exit(code)


def _die_with(zygote):
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != zygote:
        os._exit(1)


def _limit(memory_limit):
    """Bound memory and what is shared; no core file; the first to go when the machine runs out."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    with open("/proc/self/statm", "rb") as stream:
        present = int(stream.read().split()[0]) * resource.getpagesize()
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = present + memory_limit
    if hard != resource.RLIM_INFINITY:
        limit = min(limit, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # the file in memory is no memory of its own
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    most = MOST_SHARED if hard == resource.RLIM_INFINITY else min(MOST_SHARED, hard)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as stream:
        stream.write("1000")
    # before version 1.25, NumPy says so when it has no memory for the result of a comparison
    warnings.filterwarnings("error", "elementwise comparison failed", DeprecationWarning)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)  # the C library's last words; the caller has an error of his own


def _take_part(wire):
    reply = _reply(wire.receive(_ANY_SIZE))
    try:
        wire.send(reply)
    except WireError as error:
        wire.send(["failed", "WireError: %s" % error])


def _reply(request) -> Any:
    """What answer() returns, or how it failed."""
    try:
        return ["done", answer(*request)]
    except MapFileError as error:
        if isinstance(error.__cause__, MemoryError):
            return ["memory"]
        return ["refused", error.code, error.path, error.message, error.hint]
    except (MemoryError, DeprecationWarning):
        return ["memory"]
    except Exception as error:  # a hostile file may bring out what nobody has thought of
        trace = traceback.extract_tb(error.__traceback__)[-1:]
        place = "".join(" (%s, line %d)" % (os.path.basename(f.filename), f.lineno) for f in trace)
        return ["failed", "%s: %s%s" % (type(error).__name__, error, place)]


def answer(folder: str, module: str, name: str, arguments: list, keywords: dict) -> Any:
    """Call a function of a module in a folder (for relative paths)."""
    if folder:
        os.chdir(folder)
    function = importlib.import_module(module)
    for part in name.split("."):
        function = getattr(function, part)
    return function(*arguments, **keywords)
