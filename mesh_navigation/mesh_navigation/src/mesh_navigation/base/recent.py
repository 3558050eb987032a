"""A few things that were used last."""

import threading
from collections import OrderedDict
from typing import Generic, Hashable, Optional, TypeVar

Thing = TypeVar("Thing")


class Recent(Generic[Thing]):
    """Things by their keys; those that were used longest ago go. From any thread."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._lock = threading.Lock()
        self._things: "OrderedDict[Hashable, Thing]" = OrderedDict()

    def put(self, key: Hashable, thing: Optional[Thing]) -> None:
        """Keep a thing, in place of another one of this key; None only forgets that."""
        with self._lock:
            self._things.pop(key, None)
            if thing is not None:
                self._things[key] = thing
            while len(self._things) > self._size:
                self._things.popitem(last=False)

    def take(self, key: Hashable) -> Optional[Thing]:
        """The thing of a key, which is then no longer in here; None if there is none."""
        with self._lock:
            return self._things.pop(key, None)

    def find(self, key: Hashable) -> Optional[Thing]:
        """The thing of a key, which stays; None if there is none."""
        with self._lock:
            if key in self._things:
                self._things.move_to_end(key)
            return self._things.get(key)

    def clear(self) -> None:
        """Forget all."""
        with self._lock:
            self._things.clear()
