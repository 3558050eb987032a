"""Truncated and lying buffers are refused and never cost more memory than they could hold."""

import io
import struct
import tracemalloc

import genpy
import numpy as np
import pytest
from samples import ARRAY_CLASSES, encoded, filled, stock_of

from mesh_msgs import arrays

IDS = [cls.__name__ for cls in ARRAY_CLASSES]
SLACK = 200_000  # bytes that decoding a small message may take, whatever it says


def decode_bounded(cls, wire):
    """The decoded message, None where it is refused; memory stays within what the buffer holds."""
    tracemalloc.start()
    try:
        return cls().deserialize(wire)
    except genpy.DeserializationError as error:
        assert cls._type.split("/")[1] in str(error)
        return None
    finally:
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < SLACK + 50 * len(wire)


@pytest.mark.parametrize("cls", ARRAY_CLASSES, ids=IDS)
def test_every_truncation_is_refused(cls):
    wire = encoded(filled(stock_of(cls), 3))
    assert decode_bounded(cls, wire) is not None
    for size in range(len(wire)):
        with pytest.raises(genpy.DeserializationError, match="only %d|only \\d+" % size):
            cls().deserialize(wire[:size])


@pytest.mark.parametrize("size", [0, 1, 3, 4, 16, 20, 64, 1000, 100_000])
@pytest.mark.parametrize("cls", ARRAY_CLASSES, ids=IDS)
def test_a_buffer_of_0xff_is_refused(cls, size):
    assert decode_bounded(cls, b"\xff" * size) is None


@pytest.mark.parametrize(
    "lie", [0xFFFFFFFF, 0x80000000, 0x7FFFFFFF, 0x15555556, 0x00FFFFFF, 5, 4, 2]
)
@pytest.mark.parametrize("cls", ARRAY_CLASSES, ids=IDS)
def test_a_lie_anywhere_is_refused_or_means_what_genpy_reads(cls, lie):
    wire = encoded(filled(stock_of(cls), 3))
    for offset in range(len(wire) - 3):
        damaged = wire[:offset] + struct.pack("<I", lie) + wire[offset + 4 :]
        message = decode_bounded(cls, damaged)
        if message is not None:
            # Both through genpy, which turns signaling NaNs into quiet ones; arrays keep them.
            theirs = stock_of(cls)().deserialize(damaged)
            assert encoded(stock_of(cls)().deserialize(encoded(message))) == encoded(theirs)
            continue
        try:
            theirs = stock_of(cls)().deserialize(damaged)
        except genpy.DeserializationError:
            continue
        # genpy takes a string whose length lies; nothing else may be refused that it takes.
        assert len(encoded(theirs)) != len(damaged) or encoded(theirs) != damaged


def written(part):
    """The bytes of a piece of a message."""
    buffer = io.BytesIO()
    part.write_to(buffer) if hasattr(part, "write_to") else buffer.write(part)
    return buffer.getvalue()


def lengths_of(cls, wire):
    """(offset, is_string) of each length in the wire of filled(..., 3)."""
    parts, found, position = [], [], 0
    cls().deserialize(wire)._write(parts)
    for part in map(written, parts):
        if len(part) > 4 and struct.unpack("<I", part[:4])[0] == len(part) - 4:
            found.append((position, True))
        elif part == struct.pack("<I", 3):
            found.append((position, False))
        position += len(part)
    assert found and position == len(wire)
    return found


@pytest.mark.parametrize("cls", ARRAY_CLASSES, ids=IDS)
def test_every_length_that_lies_is_refused_before_anything_is_read(cls):
    wire = encoded(filled(stock_of(cls), 3))
    for offset, is_string in lengths_of(cls, wire):
        left = len(wire) - offset - 4
        # As many items as there are bytes: items of an array are larger than that.
        for lie in (0xFFFFFFFF, 0x80000000, 0x10000000, left + 1) + (() if is_string else (left,)):
            damaged = wire[:offset] + struct.pack("<I", lie) + wire[offset + 4 :]
            assert decode_bounded(cls, damaged) is None
            with pytest.raises(genpy.DeserializationError, match="%d items .* announced" % lie):
                cls().deserialize(damaged)


def test_a_refused_buffer_leaves_the_message_as_it_was():
    message = arrays.MeshVertexCosts(costs=[1, 2, 3])
    with pytest.raises(genpy.DeserializationError):
        message.deserialize(b"\xff" * 10)
    assert message.costs.tolist() == [1, 2, 3]


def test_text_that_is_not_utf8_is_replaced_as_genpy_does():
    wire = struct.pack("<II", 0, 2) + b"\xff\xfe"
    ours = arrays.MeshFaceCluster().deserialize(wire)
    assert (
        ours.label == stock_of(arrays.MeshFaceCluster)().deserialize(wire).label == "\ufffd\ufffd"
    )


def test_arrays_are_read_only_and_do_not_follow_a_mutable_buffer():
    wire = bytearray(encoded(arrays.MeshVertexCosts(costs=[1, 2, 3])))
    message = arrays.MeshVertexCosts().deserialize(wire)
    wire[:] = bytes(len(wire))
    assert message.costs.tolist() == [1, 2, 3]
    with pytest.raises(ValueError, match="read-only"):
        message.costs[0] = 5
    empty = arrays.MeshGeometry().deserialize(bytes(12))
    assert not empty.vertices.flags.writeable and empty.vertices.shape == (0, 3)
    assert empty.vertices.dtype == "<f8" and empty.faces.dtype == "<u4"


def test_decoding_copies_no_array():
    wire = encoded(arrays.MeshGeometry(vertices=[[1, 2, 3]] * 100, faces=[[0, 1, 2]] * 9))
    message = arrays.MeshGeometry().deserialize(wire)
    whole = np.frombuffer(wire, np.uint8)
    assert np.shares_memory(message.vertices, whole) and np.shares_memory(message.faces, whole)
