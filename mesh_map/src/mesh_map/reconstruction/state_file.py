"""The file beside a map with which its reconstruction goes on.

A line that says what it is, the lengths of header and data (two little endian uint64), the header
(JSON), the data of the field, and a BLAKE2b digest of all that.
"""

import hashlib
import json
import os
import struct
from typing import Any, Dict, Optional, Tuple
from urllib.parse import quote

from mesh_msgs_hdf5.files.probe import check_regular, os_error
from mesh_msgs_hdf5.files.save import save_file, write_all
from mesh_msgs_hdf5.model.errors import MapFileError

SUFFIX = ".reconstruction"
_MAGIC = b"mesh_map reconstruction 1\n"
_LENGTHS = struct.Struct("<QQ")
_DIGEST = 32  # bytes
_MOST_HEADER = 1 << 28


def state_path(map_path: str, part: Optional[str] = None) -> str:
    """Where the state of the reconstruction of a map is, or of one part of the map file."""
    plain = quote((part or "").strip("/"), safe="")
    return map_path + ("." + plain if plain else "") + SUFFIX


def save_state(path: str, header: Dict[str, Any], data: bytes) -> int:
    """Replace the state in one step; returns the size of the file.

    Raises:
        MapFileError: it cannot be saved; then the old one is there.
    """
    text = json.dumps(header, allow_nan=False).encode("utf-8")
    head = _MAGIC + _LENGTHS.pack(len(text), len(data)) + text
    hasher = hashlib.blake2b(head, digest_size=_DIGEST)
    hasher.update(data)

    def fill(descriptor: int) -> None:
        for part in (head, data, hasher.digest()):
            write_all(descriptor, part)

    save_file(path, fill)
    return len(head) + len(data) + _DIGEST


def read_state(path: str) -> Tuple[Dict[str, Any], bytes]:
    """Header and data.

    Raises:
        MapFileError: there is none, or it is damaged.
    """
    check_regular(path)
    try:
        with open(path, "rb") as stream:
            size = os.fstat(stream.fileno()).st_size
            head = stream.read(len(_MAGIC) + _LENGTHS.size)
            if not head.startswith(_MAGIC) or len(head) < len(_MAGIC) + _LENGTHS.size:
                text = "it is no state of a reconstruction, or of another version"
                raise MapFileError("format", path, text, _ANEW)
            lengths = _LENGTHS.unpack(head[len(_MAGIC) :])
            if lengths[0] > _MOST_HEADER or len(head) + sum(lengths) + _DIGEST != size:
                raise _damaged(path)
            text_bytes, data, digest = (stream.read(n) for n in (*lengths, _DIGEST))
    except OSError as error:
        raise os_error(path, error) from error
    hasher = hashlib.blake2b(head, digest_size=_DIGEST)
    hasher.update(text_bytes)
    hasher.update(data)
    if hasher.digest() != digest:
        raise _damaged(path)
    header = json.loads(text_bytes)
    return header, data


_ANEW = "begin anew, without --continue"


def _damaged(path: str) -> MapFileError:
    return MapFileError("damaged", path, "its bytes are not those that were written", _ANEW)
