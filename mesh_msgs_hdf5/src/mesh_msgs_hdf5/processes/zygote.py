"""A small process that makes others: it has everything loaded and forks one for each request,
before it comes.

A process with many threads cannot be forked safely, and starting Python with NumPy and h5py takes
0.3 s; so one is started by the first request, or by prepare(), stays single-threaded and ends with
this one. Nothing is imported here that takes time, so that a program can prepare it first of all.
"""
import array
import contextlib
import json
import os
import select
import socket
import subprocess
import sys
import threading
from typing import Optional

from mesh_msgs_hdf5 import __path__ as package_folders

# -I: not the modules of the current folder, but those of this process
_PROGRAM = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from mesh_msgs_hdf5.isolation.zygote_child import serve
serve(int(sys.argv[2]))
"""
# libraries that would start threads of their own; and libhdf5 loads no code of others
_ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "HDF5_PLUGIN_PRELOAD": "::",
    # arrays from one heap of huge pages: each process would fault in thousands of small ones anew
    "GLIBC_TUNABLES": "glibc.malloc.hugetlb=1"
    ":glibc.malloc.mmap_threshold=67108864:glibc.malloc.trim_threshold=134217728",
}
OUT_OF_MEMORY = 77  # exit status of a process that could not even say so
_END_SECONDS = 5
_STATUS_SECONDS = 10


class ZygoteEnded(Exception):
    """The zygote itself is gone: it could not be started, or something has ended it."""


class Child:
    """A forked process: its connection, and what becomes of it. Closing ends it at once.

    shared: the descriptor of a file in memory that it has, too.
    """

    def __init__(self, connection: socket.socket, status: socket.socket, shared: int) -> None:
        self.connection = connection
        self._status = status
        self.shared = shared
        self._owner = os.getpid()
        self._poll = select.poll()
        for one in (connection, status):
            self._poll.register(one, select.POLLIN)

    def wait_for_answer(self, timeout: float) -> None:
        """Return when there is something to receive, or it has ended, or after timeout seconds."""
        self._poll.poll(max(1, 1000 * timeout))

    def is_idle(self) -> bool:
        """Whether it waits for a request: it lives and has nothing to say, and is not that of the
        process which this one was forked from.
        """
        return self._owner == os.getpid() and not self._poll.poll(0)

    def wait(self) -> int:
        """Its exit status, negative for the signal that ended it, as in subprocess.

        Call this when the connection has closed. Raises ZygoteEnded.
        """
        self._status.settimeout(_STATUS_SECONDS)
        try:
            said = self._status.recv(64)
            return int(said)
        except (OSError, ValueError) as error:
            raise ZygoteEnded("nobody says how it ended") from error

    def close(self) -> None:
        """End it, whatever it is doing."""
        self._status.close()
        self.connection.close()
        os.close(self.shared)

    def end(self) -> None:
        """The same, and wait until it does nothing any more: files are as they will stay."""
        try:
            self._status.close()
            self.connection.settimeout(_END_SECONDS)
            with contextlib.suppress(OSError):
                while self.connection.recv(1 << 16):  # it is closed when the process has ended
                    pass
        finally:
            self.close()


class Zygote:
    """Starts its process at the first request; safe for threads and after os.fork.

    The process ends when this one does, in whatever way: then its socket closes.
    """

    def __init__(self) -> None:
        self._forget()
        os.register_at_fork(after_in_child=self._forget)

    def _forget(self):
        self._lock = threading.Lock()
        self._process: Optional[subprocess.Popen] = None
        self._control: Optional[socket.socket] = None

    def child(self, memory_limit: int) -> Child:
        """A new process that takes requests (zygote_child.answer) through its connection.

        memory_limit: bytes it may have beyond what it starts with. Raises ZygoteEnded.
        """
        with _pair(socket.SOCK_STREAM) as (mine, its), _pair(socket.SOCK_STREAM) as (status, end):
            with self._lock:
                self._start_if_needed()
                shared = os.memfd_create("arrays", os.MFD_CLOEXEC)
                try:
                    numbers = array.array("i", [its.fileno(), end.fileno(), shared])
                    passed = [(socket.SOL_SOCKET, socket.SCM_RIGHTS, numbers)]
                    self._control.sendmsg([b"%d" % memory_limit], passed)
                except OSError as error:
                    os.close(shared)
                    raise ZygoteEnded("no process can be forked: %s" % error) from error
            return Child(mine.dup(), status.dup(), shared)

    def start(self) -> None:
        """Start its process now, and do not wait for it. Raises OSError."""
        with self._lock:
            self._start_if_needed()

    def stop(self) -> None:
        """End it and what it has forked."""
        with self._lock:
            process, self._process = self._process, None
            if process is None:
                return
            self._control.close()
            try:
                process.wait(_END_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def _start_if_needed(self):
        if self._process is None or self._process.poll() is not None:
            self._start()

    def _start(self):
        if self._control is not None:
            self._control.close()
        # first where this package is: in a devel space of catkin its compiled module is elsewhere
        own = [os.path.dirname(folder) for folder in package_folders]
        search = json.dumps(own + [place for place in sys.path if place])
        with _pair(socket.SOCK_SEQPACKET) as (mine, its):
            self._process = subprocess.Popen(
                [sys.executable or "/usr/bin/python3", "-I", "-c", _PROGRAM, search]
                + [str(its.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                pass_fds=[its.fileno()],
                env=dict(os.environ, **_ENVIRONMENT),
                start_new_session=True,  # Ctrl+C in the terminal is for its parent, who ends it
            )
            self._control = mine.dup()


@contextlib.contextmanager
def _pair(kind):
    """Two connected sockets, closed at the end (dup what is to stay)."""
    mine, its = socket.socketpair(socket.AF_UNIX, kind)
    with mine, its:
        yield mine, its


# That of this process.
ZYGOTE = Zygote()


def prepare() -> None:
    """Start what the first file needs, which takes a third of a second, and do not wait for it.

    For programs that have other things to do until they read a file.
    """
    with contextlib.suppress(OSError):  # the first call will say what is wrong
        ZYGOTE.start()
