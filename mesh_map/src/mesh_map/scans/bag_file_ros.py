"""Bags read as far as they can be, also those that were not closed, and are never written to."""

import contextlib
import io
import struct
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Sequence

import genpy
import rosbag
from mesh_msgs_hdf5.files.probe import read_head
from mesh_msgs_hdf5.model.errors import MapFileError

_DAMAGE = (rosbag.ROSBagException, genpy.MessageException, struct.error)
# what reading damaged bytes may bring out of rosbag and its decompressors
_ERRORS = (*_DAMAGE, OSError, EOFError, ValueError, KeyError, IndexError, TypeError, MemoryError)


class BagMessage(NamedTuple):
    """A message of a topic, and when it was recorded (genpy.Time)."""

    topic: str
    message: Any
    time: Any


class BagFile:
    """A bag that is open for reading; a context manager.

    Args:
        path: of the bag.
    Attributes:
        path: of the bag.
        notes: what is odd with it.
        topics: name -> type of the messages.
        counts: name -> number of messages.
    Raises:
        MapFileError: it is no bag, or nothing of it can be read.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self.notes: List[str] = []
        if not read_head(path).startswith(b"#ROSBAG V"):
            raise MapFileError("format", path, "it is no bag of ROS 1", "rosbag info says more")
        try:
            self._bag = rosbag.Bag(path, "r", allow_unindexed=True)
        except _ERRORS as error:
            raise _unreadable(path, error) from error
        try:
            self._index()
            connections = list(self._bag._get_connections())
            self.topics: Dict[str, str] = {each.topic: each.datatype for each in connections}
            self.counts: Dict[str, int] = dict.fromkeys(self.topics, 0)
            for each in connections:
                self.counts[each.topic] += len(self._bag._connection_indexes.get(each.id, ()))
        except BaseException as error:
            self.close()
            if isinstance(error, _ERRORS):
                raise _unreadable(path, error) from error
            raise

    def __enter__(self) -> "BagFile":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        with contextlib.suppress(*_ERRORS):
            self._bag.close()

    def _index(self) -> None:
        """Make the index of a bag that has none, or only a damaged one, in memory alone."""
        indexed = bool(self._bag._connection_indexes_read)
        if not indexed:
            with contextlib.suppress(*_ERRORS):
                self._bag._get_indexes(None)
                indexed = bool(self._bag._connection_indexes_read and self._bag._connections)
        if indexed:
            return
        # it cuts off what is behind the last whole piece: a file that is open to read refuses that
        with contextlib.suppress(io.UnsupportedOperation):
            for _ in self._bag.reindex():
                pass
        self._bag._connection_indexes_read = True
        text = "%s was not closed, or ends in the middle: %d messages of it are there, and are read"
        found = sum(len(index) for index in self._bag._connection_indexes.values())
        if not found:
            hint = "was it copied to its end? rosbag reindex may say more"
            raise MapFileError("truncated", self.path, "it ends before its first message", hint)
        self.notes.append(text % (self.path, found))

    def times(self, topics: Sequence[str]) -> Optional[List[float]]:
        """[first, last] s at which messages of these topics were recorded; None for none."""
        connections = list(self._bag._get_connections(list(topics)))
        indexes = [self._bag._connection_indexes.get(each.id) for each in connections]
        ends = [each for index in indexes if index for each in (index[0], index[-1])]
        seconds = [entry.time.to_sec() for entry in ends]
        return [min(seconds), max(seconds)] if seconds else None

    def messages(
        self,
        topics: Sequence[str],
        begin: Optional[float] = None,
        most: Optional[int] = None,
    ) -> Iterator[BagMessage]:
        """Messages in the order in which they were recorded; where one cannot be read, they end
        with a note.

        Args:
            topics: none is none.
            begin: s; those recorded from then on.
            most: that many at most.
        """
        if not topics:
            return
        start = None if begin is None else genpy.Time.from_sec(max(0.0, begin))
        count = 0
        try:
            for topic, message, time in self._bag.read_messages(list(topics), start):
                yield BagMessage(topic, message, time)
                count += 1
                if count == most:
                    return
        except _ERRORS as error:
            text = "%s is damaged behind %d messages of %s, and is read up to there: %s"
            reason = str(error) or type(error).__name__
            note = text % (self.path, count, ", ".join(sorted(topics)), reason[:200])
            if note not in self.notes:
                self.notes.append(note)


def _unreadable(path: str, error: BaseException) -> MapFileError:
    if isinstance(error, MapFileError):
        return error
    text = "rosbag cannot read it: %s" % (str(error) or type(error).__name__)[:200]
    return MapFileError("damaged", path, text, "was it copied to its end? rosbag check says more")
