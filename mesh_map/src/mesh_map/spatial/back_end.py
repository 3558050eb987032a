"""Which back end answers: native code, or an OpenCL device for batches that are worth it.

From which size of a batch on a GPU is asked is decided in one place, back_end.h; a CPU is asked
where it was measured to be faster than native code, in spatial/opencl/measurement.py.
"""

import logging
import threading
from typing import Any, Callable, Dict, Iterator, List, Optional

import numpy as np

from mesh_map import _kernels
from mesh_map.base.errors import Canceled
from mesh_map.spatial.opencl.device_queries import Arrays, DeviceQueries
from mesh_map.spatial.opencl.session import Session, describe, shared_session

AUTO, NATIVE, OPENCL = "auto", "native", "opencl"
_LOG = logging.getLogger("mesh_map")


def query_counts() -> Dict[str, Dict[str, int]]:
    """Queries that this process has answered: {back end: {query: count}}.

    Back ends are native and opencl; queries ray, closest_point, sphere, frustum (boxes, too) and
    lasso; each ray or point of a batch counts. Of a batch that went to a device, what that left
    undecided counts as native besides. Those by which a device was measured count, too.
    """
    return _kernels._query_counts()


class MeshDevice:
    """The device of one index, with the mesh on it as soon as a batch is worth that.

    A batch that is worth it starts the device, in the background, and is answered natively until
    that has ended. Where the device fails, it is not asked again by this process; where only this
    mesh has no room on it, not by this index.
    """

    def __init__(self, wish: str, threads: int) -> None:
        """Args:
        wish: of mesh_map.spatial.opencl.device.device_wish().
        threads: for what is done natively.
        """
        self._wish, self._threads = wish, threads
        self._session: Optional[Session] = None
        self._refusal = ""
        self._bvh: Any = None  # what the device holds
        self._queries: Optional[DeviceQueries] = None
        self._lock = threading.Lock()

    def text(self) -> str:
        """One line: which device it is, or why there is none. Does not start it."""
        if self._refusal:
            return self._refusal
        if self._session is None:
            return "OpenCL: %s; queries are answered natively" % (
                "off" if self._wish == "off" else "not needed yet"
            )
        return self._session.text

    def wait(self) -> bool:
        """Starts the device and waits for it; whether batches can go there."""
        session = self._started()
        return session is not None and session.wait() is not None and not self._refusal

    def batch(
        self,
        query: str,
        count: int,
        back_end: str,
        bvh: Any,
        ask_device: Callable[[DeviceQueries], Iterator[Arrays]],
        ask_native: Callable[[int], Arrays],
    ) -> Arrays:
        """Answers of a batch: of the device as far as that comes, else native ones.

        Args:
            query, count, back_end, bvh: as in for_batch().
            ask_device: gives the answers of a device in order, chunk by chunk.
            ask_native: gives all answers from one query on.
        """
        parts: List[Arrays] = []
        done = 0
        device = self.for_batch(query, count, back_end, bvh)
        if device is not None:
            try:
                for part in ask_device(device):
                    parts.append(part)
                    done += len(part[0])
            except Canceled:
                raise
            except Exception as error:  # drivers fail in any way
                self.give_up(error)
            _kernels._count_opencl(query, done)
        if done < count or not parts:
            parts.append(ask_native(done))
        if len(parts) == 1:
            return parts[0]
        return tuple(np.concatenate(arrays) for arrays in zip(*parts))

    def for_batch(self, query: str, count: int, back_end: str, bvh: Any) -> Optional[DeviceQueries]:
        """The device with the mesh on it if it shall answer; None for the native queries.

        Args:
            query: as in query_counts().
            count: size of the batch.
            back_end: auto to decide by the size, opencl to wait for the device whatever the size,
                or native.
            bvh: _kernels._Bvh.
        """
        if back_end == NATIVE or self._refusal or self._wish == "off" or count == 0:
            return None
        if back_end == AUTO:
            # A device is only known when it runs; a GPU takes the smallest ones.
            if count < _kernels._device_threshold(query, True):
                return None
        session = self._started()
        if session is None:
            return None
        program = session.wait() if back_end == OPENCL else session.program
        if program is None:
            return None
        if back_end == AUTO and count < program.threshold(query):
            return None
        return self._with_mesh(program, bvh)

    def give_up(self, error: Exception) -> None:
        """After whatever a device did wrong: one warning, and native answers from then on."""
        with self._lock:
            self._queries = self._bvh = None
            memory = "MemoryError" in [kind.__name__ for kind in type(error).__mro__]
            if memory and not self._refusal:
                self._refusal = (
                    "OpenCL: the mesh has no room on the device (%s); queries about it are"
                    " answered natively" % describe(error)
                )
                _LOG.warning("%s", self._refusal)
        if not memory and self._session is not None:
            self._session.fail(error)

    def _started(self) -> Optional[Session]:
        if self._session is None and self._wish != "off":
            self._session = shared_session(self._wish)
        return self._session

    def _with_mesh(self, program: Any, bvh: Any) -> Optional[DeviceQueries]:
        try:
            with self._lock:
                if self._bvh is not bvh:
                    self._queries = self._bvh = None  # room for the next one
                    self._queries = DeviceQueries(program, bvh, self._threads)
                    self._bvh = bvh
                return self._queries
        except Exception as error:
            self.give_up(error)
            return None
