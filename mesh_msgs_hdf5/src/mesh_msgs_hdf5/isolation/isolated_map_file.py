"""Map files read in processes of their own: whatever is in the file, this process goes on.

Damaged files have made libhdf5 crash, loop for ever and take all memory. Here each of that is a
MapFileError like any other: code crashed, timeout or size. See processes/zygote.py and wire.py.
"""
import contextlib
import functools
import inspect
import os
import signal
import socket
import threading
import time
from typing import Any, Dict, Optional, Tuple

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.isolation.typed import fits, hints_of
from mesh_msgs_hdf5.isolation.wire import TooLarge, Wire, WireError
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import default_budget
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.processes.zygote import OUT_OF_MEMORY, ZYGOTE, Child, ZygoteEnded

DEFAULT_TIMEOUT = 600.0

# name -> (module, function): what may be called by isolated(); the first argument is the file
FUNCTIONS: Dict[str, Tuple[str, str]] = {
    "convert": ("mesh_msgs_hdf5.map_file.convert", "convert"),
    "repair": ("mesh_msgs_hdf5.map_file.convert", "repair"),
    "repack": ("mesh_msgs_hdf5.map_file.convert", "repack"),
    "put_part": ("mesh_msgs_hdf5.map_file.part_changes", "put_part"),
    "delete_parts": ("mesh_msgs_hdf5.map_file.part_changes", "delete_parts"),
    "parts": ("mesh_msgs_hdf5.map_file.map_file", "parts_of"),
    "scans": ("mesh_msgs_hdf5.map_file.scans", "scan_summaries"),
    "scan_rows": ("mesh_msgs_hdf5.map_file.scans", "scan_rows"),
    "check_scans": ("mesh_msgs_hdf5.map_file.scans", "check_scans"),
    "add_scans": ("mesh_msgs_hdf5.map_file.scans", "add_scans"),
    "delete_scans": ("mesh_msgs_hdf5.map_file.scans", "delete_scans"),
    "extract_scans": ("mesh_msgs_hdf5.map_file.scan_extraction", "extract_scans"),
    "other_scan_groups": ("mesh_msgs_hdf5.map_file.scan_contents", "other_groups"),
    "collada": ("mesh_msgs_hdf5.formats.dae.assimp", "scene_arrays"),
}
_USE_MAP_FILE = ("mesh_msgs_hdf5.isolation.isolated_calls", "use_map_file")
_RESTORE = "restore it from a copy, or import the mesh again"


def isolated(
    function_name: str,
    path: PathLike,
    *arguments: Any,
    memory_limit: Optional[int] = None,
    timeout: Optional[float] = None,
    library: str = "libhdf5",
    **keywords: Any,
) -> Any:
    """What a function of FUNCTIONS returns, called in a process of its own.

    path: its first argument, the file that errors are about. Arguments and result are what wire.py
    can carry. memory_limit: bytes that the process may take (default: hdf5_guard.default_budget).
    timeout: seconds (default: DEFAULT_TIMEOUT). library: what reads it there, for errors. Safe to
    call from several threads at once.

    Raises the function's MapFileError; MapFileError crashed, timeout, size if the process ended
    otherwise, and then whatever it was writing was not put in place.
    """
    arguments = (os.fsdecode(path), *(_plain(argument) for argument in arguments))
    keywords = {name: _plain(value) for name, value in keywords.items()}
    with contextlib.closing(_Reader(memory_limit, timeout, library)) as reader:
        return reader.call(path, FUNCTIONS[function_name], arguments, keywords)


class IsolatedMapFile:
    """A MapFile (which see) whose every access to the file happens in a process of its own.

    It has all public members of MapFile. memory_limit, timeout: of each call, as in isolated().
    Also a context manager: inside, one process answers one call after the other, which saves the
    time to make one for each; outside, the one that has opened the file answers the first call,
    and ends then. No file stays open between calls. After the context, or
    close(), it refuses to be used. A call after a crash is like any other. Safe for threads.
    """

    def __init__(
        self,
        path: PathLike,
        part: Optional[str] = None,
        memory_limit: Optional[int] = None,
        timeout: Optional[float] = None,
        strict: bool = False,
    ) -> None:
        self._limits = (memory_limit, timeout)
        self._kept: Optional[_Reader] = _Reader(*self._limits)
        self._keeps = True  # until the call after the first
        self._busy = threading.Lock()  # who finds the kept one busy has one made
        self._state: Optional[Dict[str, Any]] = {
            "path": os.fsdecode(path),
            "part": part,
            "strict": strict,
        }
        try:
            self._use(None, None, (), {}, opening=True)
        except BaseException:
            self.close()
            raise
        self._keeps = False

    @classmethod
    def write(cls, path: PathLike, mesh: Mesh, *arguments: Any, **keywords: Any):
        """As MapFile.write, which reads no file but the one it has just made."""
        return cls(path, MapFile.write(path, mesh, *arguments, **keywords).part)

    @classmethod
    def write_part(cls, path: PathLike, mesh: Mesh, part: str, *arguments: Any, **keywords: Any):
        """As MapFile.write_part; the file that is there may be hostile."""
        isolated("put_part", path, mesh, part, *arguments, **keywords)
        return cls(path, part)

    def close(self) -> None:
        """Refuse further calls (ValueError)."""
        self._state, self._keeps = None, False
        self._end_kept()

    def __enter__(self) -> "IsolatedMapFile":
        self._kept = self._kept or _Reader(*self._limits)
        self._keeps = True
        return self

    def __del__(self) -> None:
        if "_state" in self.__dict__:  # it was opened
            self.close()

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __getattr__(self, name: str) -> Any:
        state = self.__dict__.get("_state")
        if state is None or name.startswith("_") or name not in state:
            raise AttributeError("%s has no attribute %r" % (type(self).__name__, name))
        return state[name]

    def _use(self, member, hint, arguments, keywords, opening=False):
        """The value of MapFile's member; what the file looked like is kept for the next call."""
        old = self._state
        if old is None:
            raise ValueError("the map file is closed")
        path = old["path"]
        arguments = (path, old["part"], None if opening else old, member, arguments, keywords)
        arguments += (old["strict"],)
        with self._reader() as reader:
            answer = reader.call(path, _USE_MAP_FILE, arguments, {})
        if not fits(answer, Tuple[hint, Dict[str, Any]]):
            raise _no_answer(path, "%s: %.200r" % (member, answer))
        if self._state is not None:
            self._state = answer[1]
        return answer[0]

    @contextlib.contextmanager
    def _reader(self):
        """The kept process, where there is one that is free; else one for one call."""
        if self._busy.acquire(blocking=False):
            try:
                if self._kept is not None:
                    yield self._kept
                    return
            finally:
                self._busy.release()
                self._end_kept()
        with contextlib.closing(_Reader(*self._limits)) as reader:
            yield reader

    def _end_kept(self):
        """End the kept process where nobody wants it any more; who is using it does so later."""
        if not self._keeps and self._busy.acquire(blocking=False):
            try:
                if self._kept is not None and not self._keeps:
                    self._kept.close()
                    self._kept = None
            finally:
                self._busy.release()


def _forwarded(name, original):
    """A public member of MapFile, asked for in the other process."""
    is_property = isinstance(original, property)
    function = original.fget if is_property else original
    signature = inspect.signature(function)
    hint = hints_of(function).get("return", Any)

    @functools.wraps(function)
    def ask(self, *arguments, **keywords):
        signature.bind(self, *arguments, **keywords)  # a wrong call is a TypeError here
        return self._use(name, hint, [_plain(value) for value in arguments], keywords)

    return property(ask, doc=original.__doc__) if is_property else ask


for _name, _member in vars(MapFile).items():
    if not _name.startswith("_") and (isinstance(_member, property) or inspect.isfunction(_member)):
        setattr(IsolatedMapFile, _name, _forwarded(_name, _member))


def _plain(value):
    return os.fsdecode(value) if isinstance(value, (bytes, os.PathLike)) else value


class _Reader:
    """A process that takes calls, started by the first one; after a failure the next starts anew.

    Used by one thread at a time.
    """

    def __init__(
        self, memory_limit: Optional[int], timeout: Optional[float], library: str = "libhdf5"
    ) -> None:
        self._memory_limit = memory_limit or default_budget()
        self._timeout = timeout or DEFAULT_TIMEOUT
        self._library = library
        self._child: Optional[Child] = None
        self._wire: Any = None

    def close(self) -> None:
        """End the process."""
        child, self._child = self._child, None
        if child is not None:
            child.close()

    def call(self, path: PathLike, function: Tuple[str, str], arguments: Any, keywords: Any) -> Any:
        """What a function says of the file at path. Raises MapFileError."""
        request = [_folder(), *function, list(arguments), keywords]
        deadline = time.monotonic() + self._timeout
        try:
            reply = self._reply(path, request, deadline)
        except ZygoteEnded as error:
            self.close()
            text = "the process that reads map files cannot be started, or was ended (%s)" % error
            hint = "see its last words, and try again"
            raise MapFileError("crashed", path, text, hint) from error
        except BaseException:  # also an interrupt: who asks what was saved is told the truth
            child, self._child = self._child, None
            if child is not None:
                child.end()
            raise
        return _value_of(path, reply, self._memory_limit)

    def _reply(self, path, request, deadline):
        if self._child is not None and not self._child.is_idle():
            self.close()
        if self._child is None:
            try:
                self._child = ZYGOTE.child(self._memory_limit)
            except ZygoteEnded:  # between two requests: the next one starts it anew
                self._child = ZYGOTE.child(self._memory_limit)
            self._wire = Wire(self._child.connection, shared=self._child.shared)
        self._wire.deadline = deadline
        try:
            self._wire.send(request)
            self._child.wait_for_answer(self._timeout)
            return self._wire.receive(self._memory_limit)
        except socket.timeout as error:
            text = "reading it takes more than %g seconds" % self._timeout
            raise MapFileError("timeout", path, text, _RESTORE) from error
        except (EOFError, OSError) as error:
            code = self._child.wait()
            raise _ended(path, code, self._memory_limit, self._library) from error
        except (MemoryError, TooLarge) as error:
            raise _too_big(path, self._memory_limit) from error
        except WireError as error:
            raise _no_answer(path, error) from error


def _folder():
    try:
        return os.getcwd()
    except OSError:  # it was removed
        return ""


def _value_of(path, reply, memory_limit):
    kind, content = (reply[0], reply[1:]) if isinstance(reply, list) and reply else (None, [])
    if kind == "done" and len(content) == 1:
        return content[0]
    if kind == "memory":
        raise _too_big(path, memory_limit)
    if kind == "refused" and len(content) == 4 and all(isinstance(text, str) for text in content):
        raise MapFileError(*content)
    if kind == "failed" and len(content) == 1:
        text = "reading it failed: %s" % one_line(str(content[0]))[:300]
        raise MapFileError("crashed", path, text, _RESTORE)
    raise _no_answer(path, kind)


def _ended(path, code, memory_limit, library):
    """The error of a process that ended without an answer, with this status."""
    if code == -signal.SIGKILL:  # nobody here did it
        return _too_big(path, memory_limit, "; the system ran out of memory")
    if code == OUT_OF_MEMORY:
        return _too_big(path, memory_limit)
    if code >= 0:
        return _no_answer(path, "exit code %d" % code)
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = "signal %d" % -code
    text = "%s ended with %s while reading it" % (library, name)
    return MapFileError("crashed", path, text, _RESTORE)


def _too_big(path, memory_limit, why=""):
    text = "reading it takes more memory than the %d MiB allowed%s" % (memory_limit >> 20, why)
    return MapFileError("size", path, text, "is it a mesh map? If so, a machine with more memory")


def _no_answer(path, what):
    text = "the process that read it gave no proper answer: %s" % one_line(str(what))[:300]
    return MapFileError("crashed", path, text, _RESTORE)
