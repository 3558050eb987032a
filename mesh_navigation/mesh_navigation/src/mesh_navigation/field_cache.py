"""The fields of the last goals, so that a plan to the same goal need not begin anew."""

import threading
from collections import OrderedDict
from typing import Any, Hashable, Optional

# A field of a million vertices takes some dozens of megabytes.
_KEPT = 3


class FieldCache:
    """What plans found out about a goal; from any thread.

    A plan takes a field out and puts it back: nobody else has it meanwhile, so it does not change
    under the plan. Another plan to the same goal at the same time makes one of its own. A plan that
    fails in the middle of a change does not put the field back.
    """

    def __init__(self, size: int = _KEPT) -> None:
        self._size = size
        self._lock = threading.Lock()
        self._fields: "OrderedDict[Hashable, Any]" = OrderedDict()

    def take(self, goal: Hashable) -> Optional[Any]:
        """The field of a goal, which is then no longer in here; None if there is none."""
        with self._lock:
            return self._fields.pop(goal, None)

    def put(self, goal: Hashable, field: Any) -> None:
        """Keep a field; those that were used longest ago go."""
        with self._lock:
            self._fields.pop(goal, None)
            self._fields[goal] = field
            while len(self._fields) > self._size:
                self._fields.popitem(last=False)
