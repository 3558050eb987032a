"""What goes over the wire arrives the same; what is no message is refused, and takes no memory."""
import json
import mmap
import os
import resource
import socket
import struct
import threading
import time
from typing import Any, Dict, FrozenSet, List, Optional, Sequence, Tuple, Union

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from peak_memory import peak_memory

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.isolation.typed import fits
from mesh_msgs_hdf5.isolation import wire
from mesh_msgs_hdf5.isolation.wire import (
    MAX_DEPTH,
    MAX_HEADER_BYTES,
    SHARED_BYTES,
    Wire,
    WireError,
)
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh
from mesh_msgs_hdf5.model.schema import MATERIAL_DTYPE


def carried(value, limit=1 << 40):
    """The value as it arrives at the other end."""
    one, other = socket.socketpair()
    with one, other:
        errors = []

        def send():
            try:
                Wire(one).send(value)
            except WireError as error:
                errors.append(error)
            one.shutdown(socket.SHUT_WR)

        thread = threading.Thread(target=send)
        thread.start()
        try:
            result = Wire(other).receive(limit)
        except EOFError:
            thread.join()
            raise (errors or [AssertionError("nothing came")])[0]
        finally:
            other.shutdown(socket.SHUT_RD)  # so that the sender ends in any case
            thread.join()
        assert not errors and not other.recv(1)
        return result


def received(raw, limit=1 << 30):
    """What these bytes mean."""
    one, other = socket.socketpair()
    with other:
        with one:
            thread = threading.Thread(target=one.sendall, args=(raw,))
            thread.start()
            thread.join()
        return Wire(other).receive(limit)


def same(one, other):
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and identical(one, other)
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)):
        return type(one) is type(other) and len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, frozenset):  # whose order is another one in each process
        return type(one) is type(other) and same(sorted(one, key=repr), sorted(other, key=repr))
    if isinstance(one, (Mesh, Materials, Features, Label, Edit)):
        return type(one) is type(other) and same(vars(one), vars(other))
    return type(one) is type(other) and repr(one) == repr(other)


NAN = float("nan")
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(st.characters()),
    lambda inner: st.lists(inner)
    | st.lists(inner).map(tuple)
    | st.dictionaries(st.text() | st.integers(), inner),
    max_leaves=10,
)


@settings(max_examples=100)
@given(PLAIN)
def test_plain_values_arrive_as_they_are(value):
    assert same(carried(value), value)


@pytest.mark.parametrize(
    "value,expected",
    [
        ([NAN, -float("inf"), -0.0, 5e-324], None),
        ("\udcff\0 ä 😀", None),
        ({1: "a", "1": "b"}, None),
        (frozenset({"a", 1}), frozenset({"a", 1})),
        ({"a", "b"}, frozenset({"a", "b"})),
        (np.float32(0.1), float(np.float32(0.1))),
        (np.int64(-5), -5),
        (np.bool_(True), True),
        (np.str_("x"), "x"),
        ({"array": ["<f4", [1]]}, None),  # no confusion with what stands for an array
    ],
)
def test_special_values(value, expected):
    assert same(carried(value), value if expected is None else expected)


ARRAYS = [
    np.arange(12).reshape(3, 4).astype(kind)
    for kind in ("?", "u1", "i1", "<u2", ">i4", "<u8", "<f2", ">f4", "<f8", "g")
] + [
    np.array(3, "f4"),
    np.zeros((0, 3), "f4"),
    np.zeros((5, 0), "u4"),
    np.arange(24.0).reshape(2, 3, 4).transpose(2, 0, 1),
    np.arange(100, dtype="u4")[::-3],
    np.zeros(4, MATERIAL_DTYPE),
    np.frombuffer(b"\x01\x00\x80\x7f" * 3, "<f4"),  # a NaN with a content of its own
    np.ones(70_000, "u1"),
    np.random.default_rng(1).random((1000, 1000)),
]


@pytest.mark.parametrize("array", ARRAYS, ids=lambda array: "%s%s" % (array.dtype, array.shape))
def test_arrays_arrive_bit_for_bit(array):
    result = carried([array, {"x": array}])
    for found in (result[0], result[1]["x"]):
        assert identical(found, np.asarray(array, order="C"))
        assert found.flags.writeable and found.flags.c_contiguous and found.flags.aligned


def test_the_data_model_arrives(rich_mesh):
    assert same(carried(rich_mesh), rich_mesh)
    edit = Edit(
        vertex_costs={"a": np.ones(3, "f4"), "b": None},
        labels={"tree_1": Label(np.arange(3), (1, 2, 3)), "tree_2": None},
        remove=frozenset({"features"}),
        origin=(1.0, 2.0, 3.0),
        materials=rich_mesh.materials,
    )
    found = carried(edit)
    assert found.remove == edit.remove
    assert same(vars(found), {**vars(edit), "remove": found.remove})


def test_many_small_arrays(rich_mesh):
    rich_mesh.labels = {"a_%d" % i: Label(np.arange(i % 7)) for i in range(20_000)}
    assert same(carried(rich_mesh), rich_mesh)


@pytest.mark.parametrize(
    "value", [object(), b"bytes", {1.5: 2}, {None: 1}, 1j, np.array(["a"]), np.array([None]), Wire]
)
def test_what_cannot_be_sent_is_refused_before_anything_is(value):
    with pytest.raises(WireError, match="cannot be sent"):
        carried([1, value])


def test_depth_is_bounded():
    value = 1
    for _ in range(MAX_DEPTH):
        value = [value]
    assert carried(value) == value
    with pytest.raises(WireError, match="nested"):
        carried([[value]])


def message(header, body=b"", length=None):
    raw = header if isinstance(header, bytes) else json.dumps(header).encode()
    return b"MESH" + struct.pack("<I", len(raw) if length is None else length) + raw + body


HUGE = 1 << 40
BAD = [
    b"HSEM\0\0\0\0",
    b"GET / HTTP/1.0\r\n\r\n",
    message(b"", length=MAX_HEADER_BYTES + 1),
    message(b"[1"),
    message(b"\xff"),
    message(b"[" * 100_000),
    message(b"1" * 100_000),
    message({}),
    message({"array": ["<f4", [1]], "dict": []}),
    message({"array": 5}),
    message({"array": ["<f4"]}),
    message({"array": ["<f4", 3]}),
    message({"array": ["<f4", [-1]]}),
    message({"array": ["<f4", [1.0]]}),
    message({"array": ["<f4", [True]]}),
    message({"array": ["<f4", [HUGE]]}),
    message({"array": ["<f4", [HUGE, HUGE]]}),
    message({"array": ["<f4", [1 << 63]]}),
    message({"array": ["<f4", [10**30]]}),
    message({"array": ["<f4", [0, 1 << 47, 1 << 47]]}),
    message({"array": ["<f4", [1] * 33]}),
    message({"array": ["|O", [1]]}),
    message({"array": ["<O8", [1]]}),
    message({"array": ["<U4", [1]]}),
    message({"array": ["<M8", [1]]}),
    message({"array": ["f4,f4", [1]]}),
    message({"array": [None, [1]]}),
    message({"array": [{}, [1]]}),
    message({"array": [[["a", "|O", 0], 8], [1]]}),
    message({"array": [[["a", "<f4", 0], 2], [1]]}),
    message({"array": [[["a", "<f4", -4], 8], [1]]}),
    message({"array": [[["a", "<f4"], 8], [1]]}),
    message({"array": [[8], [1]]}),
    message({"array": [[["a", "<f4", 0], ["a", "<f4", 4], 8], [1]]}),
    message({"array": [[["a", "<f4", 0], 1 << 40], [1]]}),
    message({"dict": [1]}),
    message({"dict": [None, 1]}),
    message({"dict": [[], 1]}),
    message({"frozenset": [[1]]}),
    message({"os.system": ["command", "id"]}),
    message({"Mesh": []}),
    message({"Label": ["faces", 5]}),
    message({"Label": ["faces", {"array": ["<u4", [0]]}, "color", "red"]}),
    message({"Label": ["faces", {"array": ["<u4", [0]]}, "__class__", 1]}),
    message({"Edit": ["remove", [1]]}),
    message({"Edit": [1, 1]}),
]


@pytest.mark.parametrize("raw", BAD, ids=lambda raw: repr(raw[8:60]))
def test_what_is_no_message_is_refused(raw):
    with pytest.raises(WireError):
        received(raw)


@pytest.mark.parametrize("raw", [b"", b"MES", message([1])[:-1], message({"array": ["<f4", [9]]})])
def test_a_message_that_ends_early(raw):
    with pytest.raises(EOFError):
        received(raw)


def test_sizes_are_bounded_in_all():
    arrays = [np.zeros(1000, "u1")] * 3
    assert same(carried(arrays, limit=3000), arrays)
    with pytest.raises(WireError, match="more than"):
        received(message([{"array": ["|u1", [1000]]}] * 3, bytes(3000)), limit=2999)


def test_a_length_that_lies_takes_no_memory():
    with peak_memory() as growth:
        for raw in (message(b"[", length=MAX_HEADER_BYTES), message({"array": ["<f8", [1 << 26]]})):
            with pytest.raises(EOFError):
                received(raw)
        assert growth() < 20_000


def test_noise_is_refused(rich_mesh):
    """Mutations of a message and plain noise: an object of the data model, or one error."""
    one, other = socket.socketpair()
    with one, other:
        rich_mesh.textures = {}
        thread = threading.Thread(target=Wire(one).send, args=(rich_mesh,))
        thread.start()
        raw = bytearray(other.recv(1 << 20))
        thread.join()
    rng = np.random.default_rng(5)
    good = 0
    for _ in range(1500):
        noise = bytearray(raw)
        for place in rng.integers(0, len(raw) // 2, rng.integers(1, 4)):
            noise[place] = rng.integers(0, 256)
        try:
            good += isinstance(received(bytes(noise), 1 << 24), Mesh)
        except (WireError, EOFError):
            pass
    assert 0 < good < 1500


def test_a_deadline_is_kept():
    one, other = socket.socketpair()
    with one, other:
        started = time.monotonic()
        with pytest.raises(socket.timeout):
            Wire(other, started + 0.1).receive(1000)
        with pytest.raises(socket.timeout):
            Wire(one, started + 0.2).send(np.zeros(1 << 24, "u1"))
        with pytest.raises(socket.timeout):  # even if there is something to receive
            Wire(other, time.monotonic() - 1).receive(1 << 30)


@pytest.mark.parametrize(
    "value,hint,expected",
    [
        (1, int, True),
        (True, int, False),
        (1, float, True),
        (1.0, int, False),
        (None, Optional[int], True),
        ("a", Optional[int], False),
        (None, type(None), True),
        ([1, 2], List[int], True),
        ([1, "a"], List[int], False),
        ((1,), List[int], False),
        ((1, 2), Tuple[int, int], True),
        ((1, 2, 3), Tuple[int, int], False),
        ((1, 2, 3), Tuple[int, ...], True),
        ({"a": [1]}, Dict[str, List[int]], True),
        ({1: [1]}, Dict[str, List[int]], False),
        ({1: 2}, Dict, True),
        ({1: 2}, dict, True),
        ([1], Sequence[int], True),
        (frozenset({"a"}), FrozenSet[str], True),
        (frozenset({1}), FrozenSet[str], False),
        ("a", Union[int, str], True),
        (np.zeros(3), np.ndarray, True),
        ([0.0], np.ndarray, False),
        (object(), Any, True),
        (5, None, False),
    ],
)
def test_types_are_those_of_the_annotation(value, hint, expected):
    assert fits(value, hint) is expected


@pytest.fixture
def shared():
    """A file in memory that both ends have open."""
    descriptor = os.memfd_create("arrays")
    yield descriptor
    os.close(descriptor)


LARGE = [np.arange(SHARED_BYTES // 4, dtype="<u4"), np.ones((SHARED_BYTES, 3), "u1")]


def over(shared, value, between=lambda: None, limit=1 << 30):
    """The value as it arrives, with a shared file; between: is called before it is received."""
    one, other = socket.socketpair()
    with one, other:
        Wire(one, shared=shared).send(value)
        one.shutdown(socket.SHUT_WR)
        between()
        return Wire(other, shared=shared).receive(limit), other.recv(1)


def test_large_arrays_go_through_the_shared_file(shared):
    sizes = []
    value = LARGE + [np.arange(5), {"a": LARGE[0][::2]}]
    found, left = over(shared, value, lambda: sizes.append(os.fstat(shared).st_size))
    assert same(found, value) and not left
    assert sizes == [sum(array.nbytes for array in LARGE)]
    assert os.fstat(shared).st_size == 0  # the memory is given back
    assert same(over(shared, value)[0], value)


def test_what_has_arrived_is_not_changed_later(shared):
    """Whoever sent it may keep the file, and memory that is the file."""
    hands = []

    def keep():
        hands.append(mmap.mmap(shared, LARGE[0].nbytes))

    (found,), _ = over(shared, LARGE[:1], keep)
    expected = LARGE[0].copy()
    os.ftruncate(shared, LARGE[0].nbytes)
    hands[0][:] = b"x" * LARGE[0].nbytes
    os.pwrite(shared, b"y" * LARGE[0].nbytes, 0)
    assert identical(found, expected) and found.flags.owndata and found.flags.writeable
    os.ftruncate(shared, 0)
    assert identical(found, expected)
    hands[0].close()


def test_a_shared_file_that_is_too_short_is_refused(shared):
    with pytest.raises(WireError, match="ends behind the shared file"):
        over(shared, LARGE, lambda: os.ftruncate(shared, LARGE[0].nbytes + 1))


@pytest.mark.parametrize(
    "content",
    [
        ["|u1", [9]],
        ["|u1", [9], None],
        ["|u1", [9], -1],
        ["|u1", [9], True],
        ["|u1", [9], 0.0],
        ["|u1", [9], 1 << 48],
        ["|u1", [9], 0, 0],
        ["|O", [9], 0],
        [[], [9], 0],
        [],
    ],
)
def test_a_shared_array_that_is_none_is_refused(shared, content):
    os.ftruncate(shared, 1 << 20)
    one, other = socket.socketpair()
    with one, other:
        one.sendall(message({"shared": content}))
        with pytest.raises(WireError):
            Wire(other, shared=shared).receive(1 << 30)


def test_a_shared_array_needs_a_shared_file():
    with pytest.raises(WireError, match="there is none"):
        received(message({"shared": ["|u1", [9], 0]}))


def test_shared_arrays_count_against_the_limit(shared):
    with pytest.raises(WireError, match="more than"):
        over(shared, LARGE, limit=sum(array.nbytes for array in LARGE) - 1)


def test_more_than_may_be_shared_is_sent(shared, monkeypatch):
    monkeypatch.setattr(wire, "MOST_SHARED", LARGE[0].nbytes)
    sizes = []
    value = LARGE[:1] + [np.zeros(SHARED_BYTES, "u1")]
    found, _ = over(shared, value, lambda: sizes.append(os.fstat(shared).st_size))
    assert same(found, value) and sizes == [LARGE[0].nbytes]


def test_where_files_may_not_be_large_all_is_sent(shared):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (SHARED_BYTES - 1, before[1]))
    try:
        found, _ = over(shared, LARGE[:1])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert same(found, LARGE[:1])
