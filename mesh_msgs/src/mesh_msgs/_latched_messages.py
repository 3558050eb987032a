"""What is kept of latched messages, and what each subscriber is still to get."""

from collections import OrderedDict
from typing import Any, Callable, Dict, Hashable, Optional, Tuple


class Kept:
    """A message that is kept: as it goes over the wire, or how to make it.

    data: its bytes; None before it is made.
    make_message: None afterwards.
    spare: one that was being made when this one replaced it, so that subscribers also get
        something where messages are replaced faster than they are made.
    """

    def __init__(
        self,
        data: Optional[bytes] = None,
        make_message: Optional[Callable[[], Any]] = None,
    ) -> None:
        self.data = data
        self.make_message = make_message
        self.spare: Optional[bytes] = None


class Recipient:
    """What one subscriber is still to get, and when."""

    _POLL = 0.02  # seconds between two looks at a connection that is still writing

    def __init__(self, connection: Any, keys: Any) -> None:
        self._connection = connection
        self._keys: "OrderedDict[Hashable, None]" = OrderedDict.fromkeys(keys)
        self._written = connection.stat_num_msg
        self._not_before = 0.0

    def want(self, key: Hashable) -> None:
        """Adds a key; one that waits already keeps its place."""
        self._keys[key] = None

    def pause(self, now: float) -> Optional[float]:
        """Seconds until the next message may be sent, None if there is none."""
        if not self._keys:
            return None
        at_least = self._POLL if self._connection.stat_num_msg < self._written else 0.0
        return max(at_least, self._not_before - now)

    def first(self, messages: Dict[Hashable, Kept]) -> Tuple[Hashable, Optional[Kept]]:
        """The key that has waited longest, with its message; keys without one are dropped."""
        while self._keys:
            key = next(iter(self._keys))
            if key in messages:
                return key, messages[key]
            del self._keys[key]
        return None, None

    def expect_one(self, key: Hashable, not_before: float) -> None:
        """Notes, before the message of this key is handed to the connection, that it no longer
        waits, and when the next one may follow."""
        del self._keys[key]
        self._written = self._connection.stat_num_msg + 1
        self._not_before = not_before
