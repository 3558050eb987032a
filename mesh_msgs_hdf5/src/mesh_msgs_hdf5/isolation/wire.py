"""Values between two processes: one JSON header that names everything, behind it the arrays' bytes.

Large arrays may go another way, which is three times as fast: through a file in memory that both
have open. The receiver copies them, so that what the other one does to that file later is nothing
to it.

No pickles: what a process that has read a hostile file says can only become one of the types below,
and no length it names is believed before the bytes are there.

Known: None, bool, int, float, str, list, tuple, frozenset, dict (keys str or int), NumPy numbers
(which arrive as plain ones), arrays of bool, integers and floats (also of records of them) and the
classes of the data model. Arrays arrive C-contiguous, writable and owning their memory.
"""
import contextlib
import dataclasses
import functools
import json
import math
import os
import re
import socket
import struct
import time
from typing import Any, Callable, Iterator, List, Optional

import numpy as np

from mesh_msgs_hdf5.isolation.typed import fits, hints_of
from mesh_msgs_hdf5.model.edit import CostsUpdate, Edit
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh

MAX_HEADER_BYTES = 64 << 20
MAX_DEPTH = 100
_CLASSES = {
    known.__name__: known for known in (CostsUpdate, Edit, Features, Label, Materials, Mesh)
}
_HEAD = struct.Struct("<4sI")
_MAGIC = b"MESH"
_NUMBER = re.compile(r"[<>|=](b1|[iu][1248]|f(2|4|8|16))")
_TOGETHER = 1 << 20  # small arrays are sent together, in pieces of about this size
_BUFFER = 1 << 16
SHARED_BYTES = 1 << 17  # arrays from this size on go through the file, where there is one ...
MOST_SHARED = 1 << 28  # ... as long as all of them together are no larger than this


class WireError(ValueError):
    """Something that cannot be sent, or bytes that are no message."""


class TooLarge(WireError):
    """A message with more bytes than its receiver wants."""


class Wire:
    """One end of a connected stream socket.

    deadline: time.monotonic() at which sending and receiving end with socket.timeout.
    shared: the descriptor of a file in memory that the other end has open as well; None for none.
    """

    def __init__(
        self,
        connection: socket.socket,
        deadline: Optional[float] = None,
        shared: Optional[int] = None,
    ) -> None:
        self.deadline = deadline
        self._connection = connection
        self._shared = shared
        self._buffer = memoryview(b"")

    def send(self, value: Any) -> None:
        """Send a value. Raises WireError (then nothing was sent), OSError, socket.timeout.

        What was shared before must have been received.
        """
        arrays: List[np.ndarray] = []
        end = 0  # of what is in the shared file

        def placed(array):
            """What the header says of an array, which is shared now, or sent behind the header."""
            nonlocal end
            what = [_type_name(array.dtype), list(array.shape)]
            fits_in = SHARED_BYTES <= array.nbytes <= MOST_SHARED - end
            if fits_in and self._shared is not None:
                with contextlib.suppress(OSError):  # no room there, or more than this user may have
                    place, end = end, _write_shared(self._shared, array, end)
                    return {"shared": what + [place]}
            arrays.append(array)
            return {"array": what}

        header = json.dumps(_encoded(value, placed, 0), separators=(",", ":")).encode("ascii")
        if len(header) > MAX_HEADER_BYTES:
            raise WireError("a header of %d bytes is too long" % len(header))
        together = bytearray(_HEAD.pack(_MAGIC, len(header)) + header)
        for array in arrays:
            raw = array.reshape(-1).view(np.uint8)
            if len(raw) < _BUFFER:
                together += raw.data
            if len(raw) >= _BUFFER or len(together) > _TOGETHER:
                self._send(together)
                together = bytearray()
            if len(raw) >= _BUFFER:
                self._send(raw.data)
        if together:  # the other end may have all and be closed: even nothing cannot be sent then
            self._send(together)

    def receive(self, limit: int) -> Any:
        """The next value, whose arrays have at most limit bytes in all.

        Raises TooLarge, WireError, EOFError if the other end has closed, OSError, socket.timeout.
        """
        magic, length = _HEAD.unpack(self._read(_HEAD.size))
        if magic != _MAGIC or length > MAX_HEADER_BYTES:
            raise WireError("a message begins with %r, %d" % (magic, length))
        try:
            header = json.loads(self._read(length).decode("ascii"))
        except (ValueError, RecursionError) as error:
            raise WireError("a header is no JSON: %s" % error) from error
        value = self._decoded(header, [limit], 0)
        if self._shared is not None:
            os.ftruncate(self._shared, 0)  # gives the memory back
        return value

    def _remaining(self):
        if self.deadline is None:
            return None
        remaining = self.deadline - time.monotonic()
        if remaining <= 0:
            raise socket.timeout("the time is over")
        return remaining

    def _send(self, data):
        self._connection.settimeout(self._remaining())
        self._connection.sendall(data)

    def _read(self, length):
        """length bytes, taken in pieces: a length that lies takes no memory."""
        data = bytearray()
        while len(data) < length:
            piece = bytearray(min(length - len(data), _TOGETHER))
            self._read_into(memoryview(piece))
            data += piece
        return data

    def _read_into(self, view):
        while view:
            if not self._buffer:
                if len(view) >= _BUFFER:
                    view = view[self._receive_into(view) :]
                    continue
                fresh = memoryview(bytearray(_BUFFER))
                self._buffer = fresh[: self._receive_into(fresh)]
            taken = min(len(view), len(self._buffer))
            view[:taken] = self._buffer[:taken]
            view, self._buffer = view[taken:], self._buffer[taken:]

    def _receive_into(self, view):
        self._connection.settimeout(self._remaining())
        count = self._connection.recv_into(view)
        if not count:
            raise EOFError("the other process has ended")
        return count

    def _decoded(self, node, left, depth):
        """The value of a header's node; left: [bytes that arrays may still have]."""
        if node is None or isinstance(node, (bool, int, float, str)):
            return node
        if depth > MAX_DEPTH:
            raise WireError("values are nested more than %d deep" % MAX_DEPTH)
        if isinstance(node, list):
            return [self._decoded(item, left, depth + 1) for item in node]
        if len(node) != 1:
            raise WireError("an object with %d kinds" % len(node))
        ((kind, content),) = node.items()
        if not isinstance(content, list):
            raise WireError("%r without a list" % kind)
        if kind == "array":
            return self._array(content, left, self._read_into)
        if kind == "shared":
            place = content.pop() if content else None
            if type(place) is not int or not 0 <= place < 1 << 48:
                raise WireError("a shared array at the place %r" % (place,))
            return self._array(content, left, functools.partial(self._copy_shared, place))
        if kind in ("tuple", "frozenset"):
            items = [self._decoded(item, left, depth + 1) for item in content]
            return tuple(items) if kind == "tuple" else frozenset(_keys(items))
        if len(content) % 2:
            raise WireError("%r with an odd number of keys and values" % kind)
        names = _keys(content[::2])
        values = [self._decoded(item, left, depth + 1) for item in content[1::2]]
        found = dict(zip(names, values))
        return found if kind == "dict" else _object(kind, found)

    def _array(self, content, left, fill):
        """An array whose bytes are filled in; content: its type and shape."""
        if len(content) != 2 or not isinstance(content[1], list) or len(content[1]) > 32:
            raise WireError("an array without type and shape")
        shape = content[1]
        if not all(type(length) is int and 0 <= length < 1 << 48 for length in shape):
            raise WireError("an array of the shape %r" % (shape,))
        dtype = _dtype(content[0])
        size = dtype.itemsize * math.prod(shape)
        if size > left[0]:
            raise TooLarge("arrays of more than %d bytes" % left[0])
        left[0] -= size
        try:
            array = np.zeros(shape, dtype)
        except ValueError as error:
            raise WireError("an array of the shape %r: %s" % (shape, error)) from error
        if size:
            fill(array.reshape(-1).view(np.uint8).data)
        return array

    def _copy_shared(self, place, view):
        if self._shared is None:
            raise WireError("an array in a shared file, but there is none")
        while view:
            count = os.preadv(self._shared, [view], place)
            if not count:
                raise WireError("an array ends behind the shared file")
            view, place = view[count:], place + count


def _write_shared(shared, array, place):
    """Write an array at a place of a file; returns its end. Raises OSError."""
    view = array.reshape(-1).view(np.uint8).data
    while view:
        count = os.pwrite(shared, view, place)
        view, place = view[count:], place + count
    return place


def _encoded(value, placed: Callable[[np.ndarray], Any], depth):
    """What json can write of a value; placed takes each array of it and says what stands for it."""
    if isinstance(value, np.generic) and value.dtype.kind in "biufU":
        value = value.item()
    if value is None or type(value) in (bool, int, float, str):
        return value
    if depth > MAX_DEPTH:
        raise WireError("it is nested more than %d deep" % MAX_DEPTH)
    if isinstance(value, np.ndarray):
        return placed(np.asarray(value, order="C"))
    if isinstance(value, list):
        return [_encoded(item, placed, depth + 1) for item in value]
    for kind, container in (("tuple", tuple), ("frozenset", (frozenset, set))):
        if isinstance(value, container):
            return {kind: [_encoded(item, placed, depth + 1) for item in value]}
    name = "dict" if isinstance(value, dict) else type(value).__name__
    if name != "dict" and type(value) is not _CLASSES.get(name):
        raise WireError("a %s cannot be sent" % name)
    return {name: list(_pairs(value if name == "dict" else vars(value), placed, depth))}


def _pairs(mapping, placed, depth) -> Iterator[Any]:
    for key, item in mapping.items():
        if type(key) not in (str, int):
            raise WireError("a dict with a key of type %s cannot be sent" % type(key).__name__)
        yield key
        yield _encoded(item, placed, depth + 1)


def _keys(keys):
    if not all(type(key) in (str, int) for key in keys):
        raise WireError("a key that is neither text nor number")
    return keys


def _object(kind, found):
    known = _CLASSES.get(kind)
    hints = hints_of(known) if known else {}
    if not known or not all(fits(value, hints.get(name)) for name, value in found.items()):
        raise WireError("no object of the data model: %r with %s" % (kind, list(found)[:20]))
    for field in dataclasses.fields(known):
        required = field.default is field.default_factory is dataclasses.MISSING
        if required and field.name not in found:
            raise WireError("%r without %s" % (kind, field.name))
    return known(**found)


def _type_name(dtype):
    if dtype.names:
        parts = [(name,) + dtype.fields[name][:2] for name in dtype.names]
        return [[name, _type_name(part), place] for name, part, place in parts] + [dtype.itemsize]
    if not _NUMBER.fullmatch(dtype.str):
        raise WireError("an array of %s cannot be sent" % dtype)
    return dtype.str


def _dtype(name):
    if isinstance(name, str) and _NUMBER.fullmatch(name):
        return np.dtype(name)
    try:
        *fields, size = name
        names, formats, offsets = zip(*fields)
        if not all(isinstance(part, str) and _NUMBER.fullmatch(part) for part in formats):
            raise ValueError("formats")
        return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size})
    except (TypeError, ValueError) as error:
        raise WireError("an array of the type %.100r" % (name,)) from error
