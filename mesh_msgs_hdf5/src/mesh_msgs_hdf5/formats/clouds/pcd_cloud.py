"""PCD, the file format of PCL: ascii, binary and binary_compressed.

Format: https://pointclouds.org/documentation/tutorials/pcd_file_format.html (versions 0.5 to 0.7).
Compressed files hold one field after the other, by LZF, and have to be unpacked as a whole.
"""
import os
import struct
from typing import BinaryIO, Dict, Iterator, List

import numpy as np

from mesh_msgs_hdf5.formats.clouds.cloud import (
    BLOCK_ROWS,
    MOST_HEADER,
    Cloud,
    binary_blocks,
    checked_dtype,
    text_blocks,
    too_many,
)
from mesh_msgs_hdf5.formats.clouds.poses import matrix_of
from mesh_msgs_hdf5.map_file.hdf5.lzf import unpacked
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_KINDS = {"F": "f", "I": "i", "U": "u"}
_SIZES = {"f": ("4", "8"), "i": ("1", "2", "4", "8"), "u": ("1", "2", "4", "8")}
_UNNAMED = "_"  # of padding, which says nothing


def read_pcd_cloud(path: PathLike) -> Cloud:
    """A PCD file; fields with the name _ are padding and left out."""
    with open(path, "rb") as stream:
        head = stream.read(MOST_HEADER)
    values: Dict[str, List[str]] = {}
    start = 0
    while "DATA" not in values:
        end = head.find(b"\n", start)
        if end < 0:
            raise _odd(path, "its header has no line DATA")
        words = head[start:end].decode("latin-1").split()
        start = end + 1
        if words and not words[0].startswith("#"):
            values[words[0].upper()] = words[1:]
    dtype = _dtype(path, values)
    count = _number(path, values, "POINTS", _number(path, values, "WIDTH") * _height(path, values))
    kept = [name for name in dtype.names if not name.startswith("\0")]
    narrow = np.dtype(
        {
            "names": kept,
            "formats": [dtype[name] for name in kept],
            "offsets": [dtype.fields[name][1] for name in kept],
            "itemsize": dtype.itemsize,
        }
    )
    form = " ".join(values["DATA"])
    if form == "ascii":
        blocks = lambda: (  # noqa: E731
            b[kept] for b in text_blocks(path, start, count, dtype, alone=True)
        )
    elif form == "binary":
        if os.stat(path).st_size - start < count * dtype.itemsize:
            raise _odd(path, "it has fewer bytes than %d points need" % count)
        rest = os.stat(path).st_size - start - count * dtype.itemsize
        if rest >= dtype.itemsize:
            raise too_many(path, count + rest // dtype.itemsize, count)
        blocks = lambda: (  # noqa: E731
            b.view(narrow) for b in binary_blocks(path, start, count, dtype)
        )
    elif form == "binary_compressed":
        blocks = lambda: _compressed_blocks(path, start, count, dtype, kept)  # noqa: E731
    else:
        raise _odd(path, "its points are stored as %r" % form[:40])
    return Cloud(path, "PCD", count, narrow, blocks, _viewpoint(path, values))


def _viewpoint(path, values):
    """(4, 4) of the sensor, by VIEWPOINT tx ty tz qw qx qy qz, which old versions lack; None for
    what is none."""
    try:
        x, y, z, qw, qx, qy, qz = map(float, values.get("VIEWPOINT", "0001000"))
        return matrix_of(path, "VIEWPOINT", (x, y, z), (qx, qy, qz, qw))
    except (ValueError, MapFileError):
        return None


def _dtype(path, values):
    names = values.get("FIELDS", [])
    sizes, kinds = values.get("SIZE", []), values.get("TYPE", [])
    counts = values.get("COUNT", ["1"] * len(names))
    if not names or {len(sizes), len(kinds), len(counts)} != {len(names)}:
        raise _odd(path, "its lines FIELDS, SIZE, TYPE and COUNT differ in length")
    fields = []
    for i, (name, size, kind, number) in enumerate(zip(names, sizes, kinds, counts)):
        letter = _KINDS.get(kind, "")
        if size not in _SIZES.get(letter, ()) or not number.isdigit() or not 0 < int(number) < 4096:
            raise _odd(path, "field %s has the type %s%s[%s]" % (name[:80], kind, size, number))
        name = "\0%d" % i if name == _UNNAMED else name
        fields.append((name, "<" + letter + size) + (((int(number),),) if number != "1" else ()))
    return checked_dtype(path, fields)


def _height(path, values):
    return _number(path, values, "HEIGHT", 1)


def _number(path, values, key, default=None):
    words = values.get(key, [])
    if not words and default is not None:
        return default
    if len(words) != 1 or not words[0].isdigit() or int(words[0]) >= 1 << 40:
        raise _odd(path, "its line %s is %r" % (key, " ".join(words)[:40]))
    return int(words[0])


def _odd(path, text):
    return MapFileError("format", path, text, "is it a PCD file?")


def _compressed_blocks(path, start, count, dtype, kept):
    with open(path, "rb") as stream:
        stream.seek(start)
        sizes = stream.read(8)
        packed, size = struct.unpack("<II", sizes) if len(sizes) == 8 else (0, 0)
        if size != count * dtype.itemsize or packed > os.stat(path).st_size - start - 8:
            raise _odd(path, "its compressed points are not those of %d" % count)
        if not count:
            return
        data = unpacked(path, stream.read(packed), size)
    columns, place = {}, 0
    for name in dtype.names:
        length = count * dtype[name].itemsize
        columns[name] = data[place : place + length].view(dtype[name].base)
        columns[name] = columns[name].reshape((count,) + dtype[name].shape)
        place += length
    for row in range(0, count, BLOCK_ROWS):
        here = slice(row, min(row + BLOCK_ROWS, count))
        block = np.zeros(here.stop - here.start, [(name, dtype[name]) for name in kept])
        for name in kept:
            block[name] = columns[name][here]
        yield block


def write_pcd_cloud(
    path: PathLike, stream: BinaryIO, count: int, dtype: np.dtype, blocks: Iterator[np.ndarray]
) -> None:
    """Binary, version 0.7."""
    names, sizes, kinds, counts = [], [], [], []
    for name in dtype.names:
        base = dtype[name].base
        if str(base.itemsize) not in _SIZES.get(base.kind, ()):
            text = "PCD has no numbers of the type %s, which %s has" % (base.name, name[:80])
            raise MapFileError("dtype", path, text, "write a PLY file")
        names.append(name.replace(" ", "_"))
        sizes.append(str(base.itemsize))
        kinds.append(base.kind.upper())
        counts.append(str(int(np.prod(dtype[name].shape, dtype=int))))
    lines = ["# .PCD v0.7 - Point Cloud Data file format", "VERSION 0.7"]
    for key, words in (("FIELDS", names), ("SIZE", sizes), ("TYPE", kinds), ("COUNT", counts)):
        lines.append(" ".join([key] + words))
    lines += ["WIDTH %d" % count, "HEIGHT 1", "VIEWPOINT 0 0 0 1 0 0 0", "POINTS %d" % count]
    stream.write("\n".join(lines + ["DATA binary", ""]).encode("utf-8"))
    for block in blocks:
        stream.write(np.ascontiguousarray(block, dtype).tobytes())
