"""Framing of ROS 1 messages: lengths that are checked before anything is read, strings, errors.

On the wire every number is little-endian, a string or variable array is a uint32 length followed
by its content, and members follow each other without padding (http://wiki.ros.org/msg).
"""

import codecs
import struct
from typing import Any, List, Tuple

import genpy

_UINT32 = struct.Struct("<I")


class ArrayError(genpy.SerializationError, ValueError):
    """A member has a value that its message cannot carry: wrong shape, type, range or length.

    A ValueError for whoever assigns the member, and a SerializationError for rospy and rosbag when
    they write it.
    """


def pack(layout: struct.Struct, field: str, *values: Any) -> bytes:
    """Numbers as bytes; an ArrayError that names the field where one does not fit."""
    try:
        return layout.pack(*values)
    except (struct.error, OverflowError, TypeError) as error:
        shown = ", ".join(repr(value) for value in values[:8])
        raise ArrayError("%s: cannot write (%s): %s" % (field, shown, error)) from error


def pack_count(field: str, count: int) -> bytes:
    """The length in front of an array."""
    return pack(_UINT32, field, count)


def pack_string(field: str, text: str) -> bytes:
    """Length and UTF-8 bytes of a string."""
    if not isinstance(text, str):
        raise ArrayError("%s: expected a str, got %s" % (field, type(text).__name__))
    try:
        content = text.encode("utf-8")
    except UnicodeEncodeError as error:
        raise ArrayError("%s: cannot be written as UTF-8: %s" % (field, error)) from error
    return _UINT32.pack(len(content)) + content


class Reader:
    """Reads a serialized message from front to end and never past it.

    Every length is compared with the bytes that are left before anything is made from it, so that a
    length that lies costs neither time nor memory. Raises genpy.DeserializationError with the type,
    the field and the offset.
    """

    def __init__(self, buffer: bytes, message_type: str) -> None:
        # A mutable buffer may change under the arrays that refer to it; bytes cannot.
        self.buffer = buffer if isinstance(buffer, bytes) else bytes(buffer)
        self.offset = 0
        self.message_type = message_type
        # genpy's handler of undecodable strings names the type in its warning.
        codecs.lookup_error("rosmsg").msg_type = message_type  # type: ignore[attr-defined]

    def take(self, field: str, size: int) -> int:
        """Offset of the next `size` bytes, which are then behind the reader."""
        start = self.offset
        left = len(self.buffer) - start
        if size > left:
            raise genpy.DeserializationError(
                "%s.%s: needs %d bytes at offset %d, but only %d of %d are left; the message is "
                "truncated or damaged"
                % (self.message_type, field, size, start, left, len(self.buffer))
            )
        self.offset = start + size
        return start

    def unpack(self, field: str, layout: struct.Struct) -> Tuple[Any, ...]:
        """Numbers of a fixed layout."""
        return layout.unpack_from(self.buffer, self.take(field, layout.size))

    def count(self, field: str, item_size: int) -> int:
        """The length in front of an array whose items take `item_size` bytes or more."""
        (count,) = self.unpack(field, _UINT32)
        left = len(self.buffer) - self.offset
        if count * item_size > left:
            raise genpy.DeserializationError(
                "%s.%s: %d items of %d bytes or more are announced, but only %d bytes are left; "
                "the message is truncated or damaged"
                % (self.message_type, field, count, item_size, left)
            )
        return int(count)

    def string(self, field: str) -> str:
        """A string; bytes that are not UTF-8 are replaced and reported, as by genpy."""
        size = self.count(field, 1)
        start = self.take(field, size)
        return self.buffer[start : start + size].decode("utf-8", "rosmsg")


Parts = List[Any]  # of a message in wire order: bytes, or arrays converted when they are written
