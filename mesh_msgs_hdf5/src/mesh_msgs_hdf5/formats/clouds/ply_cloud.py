"""The vertices of a PLY file as a point cloud."""
import os
from typing import BinaryIO, Iterator, List

import numpy as np

from mesh_msgs_hdf5.formats.clouds.cloud import (
    MOST_HEADER,
    Cloud,
    binary_blocks,
    checked_dtype,
    text_blocks,
)
from mesh_msgs_hdf5.formats.ply.ply_file import TYPES
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_FORMATS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_64_BITS = ("i8", "u8")  # which we read, but no other program
_NAMES = {kind: name for name, kind in reversed(TYPES.items()) if kind not in _64_BITS}


def read_ply_cloud(path: PathLike) -> Cloud:
    """The first element of the file, which has to be vertex, without lists."""
    with open(path, "rb") as stream:
        head = stream.read(MOST_HEADER)
    end = head.find(b"\nend_header")
    start = head.find(b"\n", end + 1) + 1
    if not head.startswith(b"ply") or end < 0 or not start:
        raise MapFileError("format", path, "its header has no end_header", "is it a PLY file?")
    order, count, fields = "", -1, []
    for line in head[:end].decode("latin-1").splitlines():
        words = line.split()
        if words[:1] == ["format"] and len(words) > 1:
            order = _FORMATS.get(words[1], "")
        elif words[:1] == ["element"]:
            if count >= 0:
                break  # faces, behind the vertices
            if len(words) != 3 or words[1] != "vertex" or not words[2].isdigit():
                hint = "export the cloud alone"
                raise MapFileError("format", path, "its first element is not vertex", hint)
            count = int(words[2])
        elif words[:1] == ["property"] and count >= 0:
            if len(words) != 3 or words[1] not in TYPES:
                text = "its vertices have the property %r" % line[:80]
                raise MapFileError("format", path, text, "numbers alone are read")
            fields.append((words[2], TYPES[words[1]]))
    if not order or count < 0:
        raise MapFileError("format", path, "it has no format or no vertices", "is it a PLY file?")
    dtype = checked_dtype(path, [(name, order.strip("=") + kind) for name, kind in fields])
    if order == "=":
        return Cloud(path, "PLY", count, dtype, lambda: text_blocks(path, start, count, dtype))
    if os.stat(path).st_size - start < count * dtype.itemsize:
        text = "it has %d bytes of points, not %d"
        text %= os.stat(path).st_size - start, count * dtype.itemsize
        raise MapFileError("damaged", path, text, "the file was not written to its end")
    return Cloud(path, "PLY", count, dtype, lambda: binary_blocks(path, start, count, dtype))


def write_ply_cloud(
    path: PathLike, stream: BinaryIO, count: int, dtype: np.dtype, blocks: Iterator[np.ndarray]
) -> None:
    """Binary, little endian; fields of several columns are a property each."""
    fields: List = []
    for name in dtype.names:
        base, width = dtype[name].base, int(np.prod(dtype[name].shape, dtype=int))
        if base.str[1:] not in _NAMES:
            text = "PLY has no numbers of the type %s, which %s has" % (base.name, name[:80])
            raise MapFileError("dtype", path, text, "--format pcd")
        columns = [name] if not dtype[name].shape else ["%s_%d" % (name, i) for i in range(width)]
        fields += [(column, "<" + base.str[1:]) for column in columns]
    packed = checked_dtype(path, fields)
    lines = ["ply", "format binary_little_endian 1.0", "element vertex %d" % count]
    lines += [
        "property %s %s" % (_NAMES[kind[1:]], name.replace(" ", "_")) for name, kind in fields
    ]
    stream.write("\n".join(lines + ["end_header", ""]).encode("utf-8"))
    for block in blocks:
        stream.write(np.ascontiguousarray(block, dtype).tobytes() if packed.itemsize else b"")
