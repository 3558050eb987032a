"""Who calls the methods of a layer: one at a time, and not for ever."""

import contextvars
import math
import threading
from typing import Any, Callable, List, Optional, Tuple, TypeVar

from mesh_map.base.errors import MeshMapError

Answer = TypeVar("Answer")


def seconds_for(faces: int, timeout: Optional[float]) -> Optional[float]:
    """How long a call of a layer may take on a mesh; None for no limit.

    Args:
        faces: of the mesh.
        timeout: seconds per started million of faces; None for no limit.
    """
    return None if timeout is None else timeout * max(1, math.ceil(faces / 1e6))


class LayerWorker:
    """Calls the methods of one layer.

    With a limit each call is made in a daemon thread. One that does not return in time is left
    behind, what it still gives is ignored, and the layer is not called any more.

    Attributes:
        lock: held by whoever evaluates the layer, or changes what it reads.
        fault: why it is not called any more; empty if it is.
    """

    def __init__(self, name: str, seconds: Optional[float] = None) -> None:
        """
        Args:
            name: of the layer.
            seconds: that a call may take; None for no limit.
        """
        self._name, self._seconds = name, seconds
        self.lock = threading.RLock()
        self.fault = ""

    def call(self, work: Callable[[], Answer]) -> Answer:
        """What `work` returns; it knows the context (contextvars) of the caller.

        Raises:
            MeshMapError: it has not returned in time, now or before.
            whatever it raises.
        """
        if self.fault:
            raise MeshMapError(self.fault)
        if self._seconds is None:
            return work()
        answers: List[Tuple[Any, Optional[BaseException]]] = []
        done, context = threading.Event(), contextvars.copy_context()

        def run() -> None:
            try:
                answers.append((context.run(work), None))
            except BaseException as error:  # raised again where the caller is
                answers.append((None, error))
            done.set()

        threading.Thread(target=run, name="layer " + self._name, daemon=True).start()
        if not done.wait(self._seconds):
            self.fault = (
                "it hangs: no answer within %g s (layer_timeout); load the map anew" % self._seconds
            )
            raise MeshMapError(self.fault)
        answer, error = answers[0]
        if error is not None:
            raise error
        return answer
