"""Which received messages are served, but not in the file yet."""
import threading
from typing import Any, Collection, Dict, List, NamedTuple, Optional, Set, Tuple

import genpy


class Sent(NamedTuple):
    """A message: the topic it came on, the name in it ("" if none), the stamp of its header."""

    topic: str
    name: str
    stamp: genpy.Time


def sent_on(topic: str, message: Any) -> Sent:
    """Which one a message on one of the topics store/* or cluster_label is."""
    if hasattr(message, "texture_index"):
        return Sent(topic, str(message.texture_index), message.image.header.stamp)
    if not hasattr(message, "header"):  # MeshFeatures
        return Sent(topic, "", genpy.Time())
    name = message.cluster.label if hasattr(message, "cluster") else getattr(message, "type", "")
    return Sent(topic, name, message.header.stamp)


class Pending:
    """The newest message of each topic and name that is not in the file yet. Safe for threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._newest: Dict[Tuple[str, str], Tuple[str, Sent]] = {}
        self._told: Dict[Tuple[str, str], Set[str]] = {}  # the reasons why the newest one waits
        self._stored: List[Sent] = []

    def add(self, member: str, sent: Sent) -> None:
        """One that has changed this member of the map."""
        with self._lock:
            self._newest[sent[:2]] = member, sent
            self._told.pop(sent[:2], None)

    def now(self, but: Collection[str] = ()) -> List[Sent]:
        """All there are, but for those of these members."""
        with self._lock:
            return [sent for member, sent in self._newest.values() if member not in but]

    def store(self, sent: Collection[Sent]) -> None:
        """These are in the file; newer ones of their topics and names are not."""
        with self._lock:
            for done in sent:
                if self._newest.get(done[:2], ("", None))[1] is done:
                    del self._newest[done[:2]]
                    self._told.pop(done[:2], None)
            self._stored += sent

    def take_stored(self) -> List[Sent]:
        """Those that have got into the file since the last call."""
        with self._lock:
            stored, self._stored = self._stored, []
        return stored

    def take_waiting(self, why: str, of: Optional[str] = None) -> List[Sent]:
        """Those (of: of this member alone) that cannot be saved now; each once for each reason."""
        with self._lock:
            waiting = [
                sent
                for key, (member, sent) in self._newest.items()
                if of in (None, member) and why not in self._told.get(key, ())
            ]
            for sent in waiting:
                self._told.setdefault(sent[:2], set()).add(why)
        return waiting
