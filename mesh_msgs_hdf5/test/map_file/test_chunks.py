"""Datasets as chunks.py stores and loads them, beside what h5py itself reads and writes."""
import hashlib
import shutil
import subprocess
import sys
import threading
import zlib

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mesh_msgs_hdf5 import _deflate
from mesh_msgs_hdf5.map_file.hdf5 import chunks
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import translated_errors
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError

DTYPES = ["|u1", "|i1"] + [
    order + kind
    for order in "<>"
    for kind in ("u2", "i2", "f2", "u4", "i4", "f4", "u8", "i8", "f8")
]
FILTERS = {
    "deflate": {"compression": "gzip", "compression_opts": 9},
    "shuffle and deflate": {"compression": "gzip", "compression_opts": 4, "shuffle": True},
    "shuffle": {"shuffle": True},
    "none": {},
    "checksum": {"compression": "gzip", "shuffle": True, "fletcher32": True},
    "lzf": {"compression": "lzf", "shuffle": True},
}


def memory_file():
    return h5py.File("chunks", "w", driver="core", backing_store=False)


def same(a, b):
    """True if both are the same bytes in the same form."""
    return (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes())


def numbers(shape, dtype, seed=0, kind="smooth"):
    """Numbers of a type: bytes at random (every NaN among them), smooth ones, or all the same."""
    count = int(np.prod(shape))
    rng = np.random.default_rng(seed)
    if kind == "random":
        data = rng.bytes(count * np.dtype(dtype).itemsize)
        return np.frombuffer(data, dtype).reshape(shape)
    values = np.full(count, 7) if kind == "constant" else np.arange(count) // 3 % 120
    return values.astype(dtype).reshape(shape)


@st.composite
def arrays(draw):
    """Arrays of rank 1 to 3, often empty or of one number, in any layout in memory."""
    shape = draw(
        st.one_of(
            st.tuples(st.integers(0, 300)),
            st.tuples(st.integers(0, 90), st.integers(0, 5)),
            st.tuples(st.integers(0, 20), st.integers(0, 20), st.integers(0, 4)),
        )
    )
    kind = draw(st.sampled_from(["random", "smooth", "constant"]))
    array = numbers(shape, draw(st.sampled_from(DTYPES)), draw(st.integers(0, 9)), kind)
    layout = draw(st.sampled_from(["C", "Fortran", "backwards", "every second"]))
    if layout == "Fortran":
        return np.asfortranarray(array)
    if layout == "backwards":
        return array[::-1]
    return np.repeat(array, 2, axis=0)[::2] if layout == "every second" else array


@settings(max_examples=300)
@given(arrays(), st.one_of(st.just(chunks.CHUNK_ROWS), st.integers(1, 400)), st.integers(1, 3000))
def test_hdf5_reads_what_is_stored(array, chunk_rows, batch_bytes):
    with pytest.MonkeyPatch.context() as patch, memory_file() as file:
        patch.setattr(chunks, "CHUNK_ROWS", chunk_rows)
        patch.setattr(chunks, "_BATCH_BYTES", batch_bytes)
        dataset = chunks.store(file, "a", array)
        assert same(dataset[()], np.ascontiguousarray(array))
        assert same(chunks.load(dataset), np.ascontiguousarray(array))


@settings(max_examples=400)
@given(arrays(), st.data())
def test_loads_what_hdf5_writes(array, data):
    array = np.ascontiguousarray(array)
    options = FILTERS[data.draw(st.sampled_from(sorted(FILTERS)))]
    beyond = data.draw(st.integers(0, 4))  # chunks larger than the array need a growing one
    sides = tuple(data.draw(st.integers(1, max(1, length + beyond))) for length in array.shape)
    with memory_file() as file:
        dataset = file.create_dataset(
            "a", data=array, chunks=sides, maxshape=(None,) * array.ndim, **options
        )
        assert same(chunks.load(dataset), dataset[()])
        assert same(chunks.load(dataset), array)


@pytest.mark.parametrize("shape", [(), (0,), (0, 3), (1,), (1, 1), (5, 0, 3), (1, 1, 1)])
@pytest.mark.parametrize("compression", ["gzip", "none"])
def test_least_arrays(shape, compression):
    array = numbers(shape, "<f4")
    with memory_file() as file:
        dataset = chunks.store(file, "a", array, compression)
        assert same(np.asarray(chunks.load(dataset)), array)


def test_form_of_a_dataset():
    expected = {
        (100_000, 3): (32768, 3),
        (100_000,): (32768,),
        (5, 3): (5, 3),
        (600, 2048, 3): (170, 2048, 3),  # bytes: an image of less than 1 MiB a chunk
        (2, 3_000_000): (1, 3_000_000),
    }
    with memory_file() as file:
        for number, (shape, sides) in enumerate(expected.items()):
            dataset = chunks.store(file, str(number), np.zeros(shape, "u1"))
            filters = dataset.chunks, dataset.compression, dataset.compression_opts
            assert filters == (sides, "gzip", 1)
            assert dataset.shuffle and dataset.fletcher32 is False and dataset.maxshape == shape
        plain = chunks.store(file, "none", np.zeros((9, 3)), compression="none")
        assert plain.chunks is None and plain.compression is None
        with pytest.raises(ValueError, match="'zip' is neither gzip nor none"):
            chunks.store(file, "x", np.zeros(3), compression="zip")


def test_edge_chunks_are_padded_with_zeros(monkeypatch):
    """As HDF5 does; else the file would hold what was in memory before."""
    array = numbers((25, 3), "<u4", kind="random")
    padded = np.zeros((30, 3), "<u4")
    padded[:25] = array
    with memory_file() as file:
        monkeypatch.setattr(chunks, "CHUNK_ROWS", 10)
        dataset = chunks.store(file, "a", array)
        for row in (0, 10, 20):
            planes = padded[row : row + 10].ravel().view("u1").reshape(30, 4).T
            skipped, data = dataset.id.read_direct_chunk((row, 0))
            assert skipped == 0 and zlib.decompress(data) == planes.tobytes()


def test_structured_array():
    array = np.zeros(40_000, schema.MATERIAL_DTYPE)
    array["textureIndex"] = np.arange(40_000)
    array["g"] = np.arange(40_000) % 256
    with memory_file() as file:
        dataset = chunks.store(file, "materials", array)
        assert dataset.shuffle and dataset.compression == "gzip"
        assert same(dataset[()], array) and same(chunks.load(dataset), array)


@pytest.mark.parametrize("fill", ["never stored", "in part"])
def test_what_was_never_stored_has_the_fill_value(fill):
    with memory_file() as file:
        dataset = file.create_dataset(
            "a", (100,), "<i4", chunks=(10,), compression="gzip", fillvalue=42
        )
        if fill == "in part":
            dataset[30:45] = 7
        assert same(chunks.load(dataset), dataset[()])
        assert 42 in chunks.load(dataset)


def test_filters_that_a_chunk_skipped():
    """HDF5 stores a chunk without deflate where that does not shrink it."""
    array = numbers((64,), "<u4", kind="random")
    raw = array.tobytes()
    with memory_file() as file:
        dataset = file.create_dataset(
            "a", (64,), "<u4", chunks=(16,), compression="gzip", shuffle=True
        )
        planes = np.frombuffer(raw[:64], "u1").reshape(16, 4).T.tobytes()
        dataset.id.write_direct_chunk((0,), zlib.compress(planes), 0)
        dataset.id.write_direct_chunk((16,), zlib.compress(raw[64:128]), 1)
        planes = np.frombuffer(raw[128:192], "u1").reshape(16, 4).T.tobytes()
        dataset.id.write_direct_chunk((32,), planes, 2)
        dataset.id.write_direct_chunk((48,), raw[192:], 3)
        assert same(dataset[()], array)
        assert same(chunks.load(dataset), array)


def test_numbers_whose_bytes_differ_from_memory_are_left_to_hdf5():
    """24 bits in 4 bytes, shifted: NumPy has no such type."""
    kind = h5py.h5t.STD_I32LE.copy()
    kind.set_precision(24)
    kind.set_offset(4)
    array = np.arange(-500, 500, dtype="<i4")
    with memory_file() as file:
        properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        properties.set_chunk((100,))
        properties.set_deflate(1)
        space = h5py.h5s.create_simple((1000,))
        dataset = h5py.Dataset(h5py.h5d.create(file.id, b"a", kind, space, properties))
        dataset[...] = array
        assert np.array_equal(dataset[()], array)
        assert np.array_equal(chunks.load(dataset), array)


@pytest.mark.parametrize("order", ["shuffle last", "deflate twice", "shuffle twice"])
def test_filters_in_another_order_are_left_to_hdf5(order):
    array = numbers((1000,), "<i4")
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_chunk((100,))
    for name in {"shuffle last": "ds", "deflate twice": "sdd", "shuffle twice": "ssd"}[order]:
        (properties.set_deflate if name == "d" else properties.set_shuffle)()
    with memory_file() as file:
        space = h5py.h5s.create_simple((1000,))
        kind = h5py.h5t.STD_I32LE
        dataset = h5py.Dataset(h5py.h5d.create(file.id, b"a", kind, space, properties))
        dataset[...] = array
        assert same(dataset[()], array) and same(chunks.load(dataset), array)


def test_shuffle_by_another_width_is_left_to_hdf5(tmp_path):
    """A file may say anything: here that two bytes were an item when it was shuffled."""
    path = tmp_path / "map.h5"
    with h5py.File(path, "w") as file:
        chunks.store(file, "a", numbers((1000,), "<u4"))
    image = path.read_bytes()
    said = b"shuffle\0\x04\0\0\0"
    assert image.count(said) == 1
    path.write_bytes(image.replace(said, b"shuffle\0\x02\0\0\0"))
    with h5py.File(path, "r") as file:
        assert not np.array_equal(file["a"][()], numbers((1000,), "<u4"))
        assert same(chunks.load(file["a"]), file["a"][()])


@pytest.mark.parametrize("built", [True, False])
def test_same_file_without_the_module(monkeypatch, built):
    """Where _deflate is not built, HDF5's own filters write the same numbers in the same form."""
    calls = []
    if built:
        monkeypatch.setattr(
            chunks._deflate, "_decompress", lambda *a: calls.append(a) or _decompress(*a)
        )
    else:
        monkeypatch.setattr(chunks, "_deflate", None)
    array = numbers((70_000, 3), "<f4")
    with memory_file() as file:
        dataset = chunks.store(file, "a", array)
        assert (dataset.chunks, dataset.compression_opts, dataset.shuffle) == ((32768, 3), 1, True)
        assert same(dataset[()], array) and same(chunks.load(dataset), array)
    assert bool(calls) == built


_decompress = _deflate._decompress


READER = """
import hashlib, h5py, sys
with h5py.File(sys.argv[1], "r") as file:
    for name in sorted(file):
        print(name, hashlib.sha256(file[name][()].tobytes()).hexdigest())
assert not any("deflate" in name for name in sys.modules)
"""


def test_a_program_of_others_reads_it(tmp_path):
    path = tmp_path / "map.h5"
    data = {
        "%s %s" % (dtype[1:], kind): numbers((70_001, 3), dtype, 1, kind)
        for dtype in ("|u1", "<u4", "<f4", "<f8")
        for kind in ("random", "smooth", "constant")
    }
    with h5py.File(path, "w") as file:
        for name, array in data.items():
            chunks.store(file, name, array)
    expected = "".join(
        "%s %s\n" % (name, hashlib.sha256(data[name].tobytes()).hexdigest())
        for name in sorted(data)
    )
    command = [sys.executable, "-I", "-c", READER, str(path)]
    done = subprocess.run(command, stdout=subprocess.PIPE, timeout=120, check=True)
    assert done.stdout.decode() == expected
    if shutil.which("h5dump"):
        command = ["h5dump", "-d", "/u1 smooth", "-b", "LE", "-o", str(tmp_path / "raw"), str(path)]
        subprocess.run(command, stdout=subprocess.DEVNULL, timeout=120, check=True)
        assert (tmp_path / "raw").read_bytes() == data["u1 smooth"].tobytes()


def test_one_chunk_as_large_as_the_array():
    """As LVR2 writes: deflate 9 without shuffle."""
    array = numbers((50_000, 3), "<f4")
    with memory_file() as file:
        dataset = file.create_dataset("a", data=array, chunks=array.shape, **FILTERS["deflate"])
        assert same(chunks.load(dataset), array)


def stored_chunk(file, data, deflated):
    dataset = file.create_dataset(
        "mesh/a", (len(data),), "u1", chunks=(len(data) // 2,), compression="gzip"
    )
    dataset.id.write_direct_chunk((0,), zlib.compress(bytes(data[: len(data) // 2])))
    dataset.id.write_direct_chunk((len(data) // 2,), deflated)
    return dataset


@pytest.mark.parametrize(
    "deflated, message",
    [
        (zlib.compress(b"x" * 99), "chunk 1 holds less than its 100 bytes"),
        (zlib.compress(b"x" * 101), "chunk 1 holds more than its 100 bytes"),
        (zlib.compress(b"x" * 10_000_000), "chunk 1 holds more than its 100 bytes"),
        (zlib.compress(b""), "chunk 1 holds less than its 100 bytes"),
        (zlib.compress(b"x" * 100)[:-4] + b"abcd", "chunk 1 is damaged"),
        (zlib.compress(b"x" * 100)[:-1], "chunk 1 is damaged"),
        (zlib.compress(b"x" * 100)[2:], "chunk 1 is damaged"),
        (b"\x78\x01", "chunk 1 is damaged"),
        (b"\0" * 50, "chunk 1 is damaged"),
    ],
)
def test_a_damaged_chunk_is_named(deflated, message):
    with memory_file() as file:
        dataset = stored_chunk(file, b"x" * 200, deflated)
        with pytest.raises(OSError, match="/mesh/a: " + message):
            chunks.load(dataset)
        with pytest.raises(MapFileError, match=message) as caught:
            with translated_errors("map.h5"):
                chunks.load(dataset)
        assert caught.value.code == "damaged"


def test_damage_is_found_or_does_no_harm():
    """Every byte of a chunk changed, cut off and random: an error, or the right numbers."""
    rng = np.random.default_rng(3)
    array = numbers((400,), "<u4", kind="smooth")
    planes = array.view("u1").reshape(400, 4).T.tobytes()
    outcomes = {"right": 0, "error": 0}
    for level in (0, 1, 9):
        good = zlib.compress(planes, level)
        changed = [good + b"more"]
        for place in range(len(good)):
            for bit in range(8) if len(good) < 500 else (0, 7):
                changed.append(good[:place] + bytes([good[place] ^ 1 << bit]) + good[place + 1 :])
            changed.append(good[:place])
        for _ in range(200):
            place, length = rng.integers(0, len(good)), rng.integers(1, 40)
            changed.append(good[:place] + rng.bytes(length) + good[place + length :])
        for data in changed:
            output = np.zeros(400, "<u4")
            try:
                _decompress([(data, True, True, output)], 0)
            except RuntimeError as error:
                assert str(error).startswith("chunk 0 ")
                outcomes["error"] += 1
            else:
                assert same(output, array)
                outcomes["right"] += 1
    assert outcomes["error"] > 2000 and outcomes["right"] >= 3


@settings(max_examples=500)
@given(st.data())
def test_nothing_outside_of_a_chunk_is_written(data):
    """Whatever the bytes are, those around the chunks stay."""
    sides = tuple(data.draw(st.lists(st.integers(1, 12), min_size=1, max_size=3)))
    dtype = np.dtype(data.draw(st.sampled_from(DTYPES)))
    whole = int(np.prod(sides)) * dtype.itemsize
    around = [np.full(64 + whole + 64, 0xA5, "u1") for _ in range(data.draw(st.integers(1, 9)))]
    stored, wrong = [], False
    for memory in around:
        length = max(0, whole + data.draw(st.sampled_from([0, 0, 0, 0, -1, 1, 500])))
        wrong = wrong or length != whole
        raw = np.random.default_rng(data.draw(st.integers(0, 99))).bytes(length)
        shuffled, deflated = data.draw(st.booleans()), data.draw(st.booleans())
        chunk = memory[64 : 64 + whole].view(dtype).reshape(sides)
        stored.append((zlib.compress(raw) if deflated else raw, shuffled, deflated, chunk))
    if wrong:
        with pytest.raises(RuntimeError, match="than its %d bytes" % whole):
            _decompress(stored, 0)
    else:
        _decompress(stored, 0)
    for memory in around:
        assert (memory[:64] == 0xA5).all() and (memory[64 + whole :] == 0xA5).all()


def test_chunks_far_larger_than_the_array_are_refused():
    with memory_file() as file:
        dataset = file.create_dataset(
            "bomb", (10,), "u1", chunks=(70 << 20,), maxshape=(None,), compression="gzip"
        )
        with pytest.raises(ValueError, match="/bomb: chunks of 73400320 bytes for an array of 10"):
            chunks.load(dataset)


def test_any_number_of_threads_gives_the_same_bytes():
    """A chunk alone is compressed by one thread, many by as many as there are cores."""
    parts = np.split(numbers((100_000, 3), "<f4", kind="random"), 100)
    one = [_deflate._compress([part])[0] for part in parts]
    assert _deflate._compress(parts) == one
    output = [np.zeros_like(part) for part in parts]
    _decompress([(data, True, True, chunk) for data, chunk in zip(one, output)], 0)
    assert all(map(same, output, parts))


def test_several_threads_at_a_time():
    array = numbers((100_000, 3), "<f4")
    results = [None] * 4

    def work(number):
        data = _deflate._compress(np.split(array + number, 100))
        results[number] = np.zeros_like(array)
        stored = zip(data, np.split(results[number], 100))
        _decompress([(chunk, True, True, part) for chunk, part in stored], 0)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(same(result, array + number) for number, result in enumerate(results))


def test_arguments_of_the_module_are_checked():
    array = np.zeros((10, 3), "<f4")
    read_only = array.copy()
    read_only.flags.writeable = False
    (good,) = _deflate._compress([array])
    wrong = (
        array[:, ::2],
        array.T,
        array.astype(object),
        array.astype("S4"),
        array.astype("c8"),
        array.astype(np.longdouble),
        array[:0],
    )
    for chunk in wrong:
        with pytest.raises(ValueError):
            _deflate._compress([array, chunk])
    for chunk in (*wrong, read_only):
        with pytest.raises(ValueError):
            _decompress([(good, True, True, chunk)], 0)
    with pytest.raises(TypeError):
        _deflate._compress([array.tolist()])
    for stored in (
        [good],
        [(good, True, True)],
        [("text", True, True, array)],
        [(bytearray(good), True, True, array)],
        [(good, True, True, array.tolist())],
    ):
        with pytest.raises(TypeError):
            _decompress(stored, 0)
    with pytest.raises(TypeError):
        _decompress([(good, True, True, array)], -1)
