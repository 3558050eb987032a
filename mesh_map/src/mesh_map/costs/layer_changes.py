"""What has changed, and who is told."""

import collections
import logging
import threading
from typing import Callable, Deque, Dict, List, Mapping, NamedTuple, Optional, Sequence

import numpy as np

from mesh_map.base.errors import PLUGIN_FAILURES, error_line
from mesh_map.costs.layer import LayerResult

_LOG = logging.getLogger("mesh_map")
_PATIENCE = 1.0  # seconds


class LayerChange(NamedTuple):
    """A change of published costs.

    name: of a layer, or mesh_map.costs.combination.COMBINED_COSTS.
    vertices: (K,) uint32, ascending: where costs or vectors are others than before.
    costs: (V,) float32, of all vertices, read-only.
    """

    name: str
    vertices: np.ndarray
    costs: np.ndarray


Listener = Callable[[List[LayerChange]], None]


def different(before: Optional[np.ndarray], after: Optional[np.ndarray]) -> np.ndarray:
    """(K,) ascending: the rows in which arrays of the same shape differ bitwise; NaN is like NaN.

    None is like zeros, in vectors.
    """
    if before is after:
        return np.zeros(0, np.int64)
    if before is None or after is None:
        array = after if before is None else before
        return np.flatnonzero(array.any(axis=1))
    if before.dtype == np.bool_:
        return np.flatnonzero(before != after)
    one, other = before.ravel(), after.ravel()
    places = np.flatnonzero(one.view(np.uint32) != other.view(np.uint32))
    places = places[~(np.isnan(one[places]) & np.isnan(other[places]))]
    return places if before.ndim == 1 else np.unique(places // before.shape[1])


def union(parts: Sequence[np.ndarray], count: int) -> np.ndarray:
    """(K,) uint32, ascending: indices below `count` that are in any of the parts."""
    parts = [part for part in parts if len(part)]
    if sum(map(len, parts)) < count // 16:
        together = np.concatenate(parts) if parts else np.zeros(0)
        return (np.unique(together) if len(parts) > 1 else together).astype(np.uint32)
    mask = np.zeros(count, np.bool_)
    for part in parts:
        mask[part] = True
    return np.flatnonzero(mask).astype(np.uint32)


class ResultDifference(NamedTuple):
    """Ascending (K,) uint32 vertices at which two results differ.

    read: in anything, which matters to layers that read it.
    shown: in costs or vectors, which is what is published.
    """

    read: np.ndarray
    shown: np.ndarray

    @classmethod
    def between(cls, before: Optional[LayerResult], after: LayerResult) -> "ResultDifference":
        """All vertices if there was nothing before."""
        count = len(after.costs)
        if before is None:
            everything = np.arange(count, dtype=np.uint32)
            return cls(everything, everything)
        costs, vectors = different(before.costs, after.costs), different(
            before.vectors, after.vectors
        )
        shown = union([costs, vectors], count)
        return cls(union([shown, different(before.lethal, after.lethal)], count), shown)


class PendingChanges:
    """What has changed and nobody was told of yet, of all threads: so that the costs of one that is
    told differ from those told before at its vertices alone. The caller locks.
    """

    def __init__(self) -> None:
        self._vertices: Dict[str, List[np.ndarray]] = {}
        self._before: Dict[str, np.ndarray] = {}

    def add(self, name: str, vertices: np.ndarray, before: Optional[np.ndarray]) -> None:
        """vertices: (K,) ascending, where costs or vectors differ; before: (V,) the costs before,
        where nothing else may differ."""
        if name not in self._vertices and before is not None:
            self._before[name] = before
        self._vertices.setdefault(name, []).append(vertices)

    def taken(self, costs: Mapping[str, np.ndarray]) -> List[LayerChange]:
        """All of it, in the order of `costs`: name -> (V,) of now; without what is as before."""
        parts, before = self._vertices, self._before
        self._vertices, self._before = {}, {}
        changes = []
        for name in costs:
            vertices = union(parts.get(name, ()), len(costs[name]))
            if name in before and len(parts[name]) > 1:
                vertices = vertices[different(before[name][vertices], costs[name][vertices])]
            if len(vertices):
                changes.append(LayerChange(name, vertices, costs[name]))
        return changes


class Listeners:
    """Callbacks that are told of each change once, in order, by one thread at a time.

    They are called without any lock of the map, so they may use it freely. Where a thread makes a
    change while another one tells of the change before, that one tells of both. The thread that
    made the change waits for that, so changes do not pile up before listeners that are slower.
    """

    def __init__(self) -> None:
        self._listeners: List[Listener] = []
        self._waiting: Deque[List[LayerChange]] = collections.deque()
        self._editing = threading.Lock()
        self._telling = threading.Lock()
        self._teller: Optional[int] = None  # the thread that holds _telling

    def add(self, listener: Listener) -> None:
        with self._editing:
            self._listeners = self._listeners + [listener]

    def remove(self, listener: Listener) -> None:
        """One that was not added is no error."""
        with self._editing:
            self._listeners = [known for known in self._listeners if known != listener]

    def put(self, changes: List[LayerChange]) -> None:
        """Adds what tell() is to tell; called in the order of the changes."""
        if changes:
            self._waiting.append(changes)

    def tell(self) -> None:
        """Tells what was put, or waits until another thread has told it.

        Not for a call by a listener, nor for long: that thread may be waiting for this one.
        """
        while self._waiting and self._begin():
            try:
                while self._waiting:
                    self._tell_all_of(self._waiting.popleft())
            finally:
                self._teller = None
                self._telling.release()

    def _begin(self) -> bool:
        this = threading.get_ident()
        if self._teller == this or not self._telling.acquire(timeout=_PATIENCE):
            return False
        self._teller = this
        return True

    def _tell_all_of(self, changes: List[LayerChange]) -> None:
        for listener in self._listeners:
            try:
                listener(list(changes))
            except PLUGIN_FAILURES as error:  # the others are told nevertheless
                _LOG.error("a listener failed with %s", error_line(error))
