"""Names in natural order, to which more are added one by one."""
import bisect
from typing import Any, Iterable, List, Tuple

from mesh_msgs_hdf5.reading.label_reader import natural_order


class NaturalNames:
    """Texts, each once, with tree_2 before tree_10; adding one to many takes microseconds."""

    def __init__(self, texts: Iterable[str] = ()) -> None:
        self._entries: List[Tuple[Any, str]] = sorted((natural_order(t), t) for t in set(texts))

    def __len__(self) -> int:
        return len(self._entries)

    def texts(self) -> List[str]:
        """All, in order."""
        return [text for _, text in self._entries]

    def add(self, text: str) -> None:
        """Without effect if it is there."""
        place, entry = self._place(text)
        if self._entries[place : place + 1] != [entry]:
            self._entries.insert(place, entry)

    def discard(self, text: str) -> None:
        """Without effect if it is not there."""
        place, entry = self._place(text)
        if self._entries[place : place + 1] == [entry]:
            del self._entries[place]

    def _place(self, text):
        entry = natural_order(text), text
        return bisect.bisect_left(self._entries, entry), entry
