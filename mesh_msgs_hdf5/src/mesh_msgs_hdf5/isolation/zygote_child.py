"""The zygote's program: forks a process for each request and says how it ended."""
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
from typing import Any, Dict, Iterator, NoReturn, Optional, Tuple

import numpy as np

import mesh_msgs_hdf5.isolation.isolated_calls  # noqa: F401 (loads all that is needed once for all)
from mesh_msgs_hdf5.isolation.wire import MOST_SHARED, Wire, WireError
from mesh_msgs_hdf5.processes.zygote import OUT_OF_MEMORY
from mesh_msgs_hdf5.map_file.reading.map_reader import MapReader
from mesh_msgs_hdf5.map_file.writing.hdf5_stream import (
    Stream,
    building,
    memory_stream,
    reading_stream,
)
from mesh_msgs_hdf5.map_file.writing.map_saving import part_group
from mesh_msgs_hdf5.map_file.writing.object_writer import ObjectWriter
from mesh_msgs_hdf5.map_file.writing.part_writer import PartWriter
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Mesh

_LIBC = ctypes.CDLL(None)
_PR_SET_PDEATHSIG = 1
_LOOK_SECONDS = 5
_ANY_SIZE = 1 << 48
_WARM_BYTES = 1 << 20


def serve(number: int) -> NoReturn:
    """Give each request on the socket with this number to a forked process, until it closes.

    A request is the memory limit, two sockets and a file in memory: the process answers on the
    first socket, large arrays in the file; the second is told its exit status, and when the other
    end of that closes, it is killed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    warm_map = _warm_map()
    _warm_up(warm_map)
    gc.collect()
    gc.freeze()  # so that the collector touches no page that is shared
    forks = _Forks(socket.socket(fileno=number), warm_map)  # whose sockets stay open to the end
    forks.serve()
    os._exit(0)  # and with it all that it has forked, see _die_with


def _warm_map() -> Optional[Stream]:
    """A small map in memory; None where there is no room for it."""
    mesh = Mesh(np.eye(3, dtype=np.float32), np.arange(3, dtype=np.uint32)[None])
    mesh.vertex_normals, mesh.vertex_costs = mesh.vertices, {"a": np.zeros(3, np.float32)}
    with contextlib.suppress(MapFileError, OSError), memory_stream(_WARM_BYTES) as stream:
        with building(stream, stream.name) as file:
            writer = ObjectWriter(stream.name)
            PartWriter(writer, part_group(writer, file, "mesh")).mesh(mesh)
        return Stream(os.dup(stream.descriptor))
    return None


def _warm_up(warm_map):
    """Load, set up and touch what reading a map needs."""
    if warm_map is not None:
        with reading_stream(warm_map, warm_map.name) as file:
            MapReader(file, warm_map.name, None).read()


class _Forks:
    """The processes that the zygote has forked: those at work, and a spare one.

    The spare one is forked and warmed up before it is asked for. It has seen no file of others
    until it is given a request, and takes no second one.
    """

    def __init__(self, control: socket.socket, warm_map: Optional[Stream]) -> None:
        self._control = control
        self._warm_map = warm_map
        self._wake, self._waker = socket.socketpair()
        self._waker.setblocking(False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(self._waker.fileno(), warn_on_full_buffer=False)
        self._at_work: Dict[socket.socket, int] = {}  # who is told how it ended -> its id
        self._spare: Optional[Tuple[int, socket.socket]] = None

    def serve(self) -> None:
        """Until nobody is left who may ask."""
        parent = os.getppid()
        self._fork_spare()
        while os.getppid() == parent:  # who has forked too may keep the socket open
            at_work = self._at_work
            ready, _, _ = select.select(
                [self._control, self._wake, *at_work], [], [], _LOOK_SECONDS
            )
            if self._control in ready and not self._take_request():
                break
            if self._wake in ready:
                self._wake.recv(4096)
            for status in set(ready) & set(at_work):
                with status:  # nobody waits for it any more; its id is its own until it is reaped
                    os.kill(at_work.pop(status), signal.SIGKILL)
            self._reap()

    def _take_request(self):
        """Give the next request to the spare process; False if there will be none."""
        message, numbers = _receive(self._control, 3)
        if not message or len(numbers) != 3:
            return False
        connection, end, shared = numbers
        status = socket.socket(fileno=end)
        pid = self._give(message, [connection, shared])
        if pid is None:  # something has ended the spare one, or it could not be forked
            self._fork_spare()
            pid = self._give(message, [connection, shared])
        for number in (connection, shared):
            os.close(number)
        if pid is None:  # whoever asks is told by the closed connection
            status.close()
        else:
            self._at_work[status] = pid
        self._fork_spare()
        return True

    def _give(self, message, numbers):
        """The id of the spare process, which has the request now; None if there is none."""
        spare, self._spare = self._spare, None
        if spare is None:
            return None
        pid, channel = spare
        with channel:
            try:
                passed = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", numbers))]
                channel.sendmsg([message], passed)
            except OSError:  # then it ends, if it has not yet
                return None
        return pid

    def _fork_spare(self):
        mine, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        zygote = os.getpid()
        try:
            pid = os.fork()
        except OSError:  # too many processes; the next request tries again
            mine.close()
            its.close()
            return
        if not pid:
            signal.set_wakeup_fd(-1)
            for other in (mine, self._control, self._wake, self._waker, *self._at_work):
                other.close()
            _run(its, self._warm_map, zygote)
        its.close()
        self._spare = pid, mine

    def _reap(self):
        """Take leave of those that have ended, and say how to who waits for it."""
        while True:
            try:
                pid, state = os.waitpid(-1, os.WNOHANG)
            except ChildProcessError:
                return
            if not pid:
                return
            code = -os.WTERMSIG(state) if os.WIFSIGNALED(state) else os.WEXITSTATUS(state)
            for status in [one for one, its in self._at_work.items() if its == pid]:
                del self._at_work[status]
                with status, contextlib.suppress(OSError):
                    status.sendall(b"%d" % code)


def _receive(channel, count):
    """A message, and the numbers of at most count descriptors that came with it."""
    size = socket.CMSG_SPACE(count * array.array("i").itemsize)
    message, passed, _, _ = channel.recvmsg(64, size, socket.MSG_CMSG_CLOEXEC)
    numbers = array.array("i")
    for _, _, data in passed:
        numbers.frombytes(data)
    return message, numbers


def _run(channel, warm_map, zygote) -> NoReturn:
    """The forked process: an answer to each call of one request, until its connection closes."""
    code = 1
    try:
        _die_with(zygote)
        _prepare()
        _warm_up(warm_map)
        if warm_map is not None:  # it must not change that of others
            os.close(warm_map.descriptor)
        with channel:
            message, numbers = _receive(channel, 2)
        if message:
            _limit_memory(int(message))
            connection, shared = numbers
            wire = Wire(socket.socket(fileno=connection), shared=shared)
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


def _prepare():
    """Bound what is shared; no core file; the first to go when the machine runs out of memory."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # the file in memory is no memory of its own
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    most = MOST_SHARED if hard == resource.RLIM_INFINITY else min(MOST_SHARED, hard)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as stream:
        stream.write("1000")
    # before version 1.25, NumPy says so when it has no memory for the result of a comparison
    warnings.filterwarnings("error", "elementwise comparison failed", DeprecationWarning)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)  # the C library's last words; the caller has an error of his own


def _limit_memory(most):
    """Bound the memory that it takes from now on."""
    with open("/proc/self/statm", "rb") as stream:
        present = int(stream.read().split()[0]) * resource.getpagesize()
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = present + most
    if hard != resource.RLIM_INFINITY:
        limit = min(limit, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def _take_part(wire):
    request = wire.receive(_ANY_SIZE)
    with _large_files():
        reply = _reply(request)
    try:
        wire.send(reply)
    except WireError as error:
        wire.send(["failed", "WireError: %s" % error])


@contextlib.contextmanager
def _large_files() -> Iterator[None]:
    """While nothing is shared: a map that is written may be larger than what may be shared."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


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
