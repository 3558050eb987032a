"""A device of this process: started in the background, shared by all meshes.

A device that does not start, or fails later, is not asked again by this process. A process that is
forked from one in which OpenCL has been started cannot use it: it answers natively.
"""

import logging
import os
import threading
from typing import Dict, Optional

from mesh_msgs.text import one_line

from mesh_map.spatial.opencl.device import OFF, choose_device, list_devices
from mesh_map.spatial.opencl.program import DeviceProgram
from mesh_map.spatial.opencl.program_cache import ProgramCache

_LOG = logging.getLogger("mesh_map")
_NATIVE = "OpenCL: %s; queries are answered natively"
_FORKED = "this process was forked from one that uses OpenCL"


class Session:
    """The device of a wish (see device_wish()), and its program once that is ready."""

    def __init__(self, wish: str) -> None:
        self._text = _NATIVE % "the device is starting"
        self._wish = wish
        self._program: Optional[DeviceProgram] = None
        self._failed = False
        self._ended = threading.Event()
        self._process = 0  # that has started it
        self._lock = threading.Lock()

    @property
    def text(self) -> str:
        """One line: the device, or why there is none."""
        return self._text if self._process == os.getpid() else _NATIVE % _FORKED

    @property
    def program(self) -> Optional[DeviceProgram]:
        """None where it is not ready, or has failed."""
        return None if self._failed or self._process != os.getpid() else self._program

    def wait(self) -> Optional[DeviceProgram]:
        """The program, or None, once the start has ended."""
        if self._process == os.getpid():
            self._ended.wait()
        return self.program

    def fail(self, error: Exception) -> None:
        """Gives the device up; a warning the first time."""
        with self._lock:
            if self._failed:
                return
            self._text, self._failed = _NATIVE % describe(error), True
        self._program = None
        _LOG.warning("%s", self._text)

    def start(self) -> None:
        """In a thread that the interpreter waits for at its end: drivers break when they are torn
        down while they compile.
        """
        self._process = os.getpid()
        thread = threading.Thread(target=self._run, name="mesh_map OpenCL start", daemon=False)
        try:
            thread.start()
        except RuntimeError as error:  # no thread is to be had
            self.fail(error)
            self._ended.set()

    def _run(self) -> None:
        try:
            program = self._started()
            how = "from the cache" if program.from_cache else "compiled"
            self._text = _text(program) % (program.info.text(), how)
            self._program = program
            _LOG.info("%s", self._text)
        except Exception as error:  # drivers, compilers and files fail in any way
            self.fail(error)
        finally:
            self._ended.set()

    def _started(self) -> DeviceProgram:
        from mesh_map.spatial.opencl.check import check_device
        from mesh_map.spatial.opencl.measurement import faster_from

        devices, infos = list_devices()
        chosen = choose_device(infos, self._wish)
        if chosen is None:
            there = ", ".join(info.text() for info in infos) or "none"
            raise RuntimeError(
                "no device fits the wish '%s' (there is: %s; see MESH_TOOLS_OPENCL)"
                % (self._wish or "any", there)
            )
        cache = ProgramCache()
        program = DeviceProgram(devices[chosen], infos[chosen], cache)
        check_device(program)
        program.keep()
        if program.info.type != "GPU":
            program.faster_from = faster_from(program, cache)
        return program


def _text(program: DeviceProgram) -> str:
    if program.info.type == "GPU" or program.faster_from:
        return "OpenCL: batches of queries are answered by %s, program %s"
    return "OpenCL: native code is faster than %s, program %s, and answers unless told otherwise"


def describe(error: Exception) -> str:
    """One line about an error."""
    if isinstance(error, ImportError):
        return "pyopencl cannot be imported (%s; Debian: python3-pyopencl)" % one_line(error)
    text = one_line(error) or "no reason given"
    if "PLATFORM_NOT_FOUND" in text:
        text += " (no platform: Debian's pocl-opencl-icd makes a device of any processor)"
    return "%s: %s" % (type(error).__name__, text[:600])


class _Registry:
    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.sessions: Dict[str, Session] = {}
        self.forked = False  # from a process that had sessions


_REGISTRY = _Registry()


def _after_fork() -> None:
    """In the child: locks and threads are gone."""
    global _REGISTRY
    forked = _REGISTRY.forked or bool(_REGISTRY.sessions)
    _REGISTRY = _Registry()
    _REGISTRY.forked = forked


os.register_at_fork(after_in_child=_after_fork)


def shared_session(wish: str) -> Optional[Session]:
    """The session of a wish in this process, started the first time; None for "off"."""
    if wish == OFF:
        return None
    with _REGISTRY.lock:
        session = _REGISTRY.sessions.get(wish)
        if session is None:
            session = _REGISTRY.sessions[wish] = Session(wish)
            if not _REGISTRY.forked:
                session.start()
        return session
