"""The lines of a label journal: each one a JSON object that carries the checksum of its rest.

    {"crc":"eb6f64fa","set":"tree_1","color":[0,128,0],"count":3,"u4":"AQAAAAIAAAADAAAA"}

The checksum is zlib's crc32 of the bytes of the line without that member, in eight hexadecimal
digits; it always comes first. Entries are absolute, so that replaying one twice changes nothing:

    journal  the first line: format, version, uuid of the geometry, part, number of faces (null if
             it is not known)
    owner    who opened the journal to write, and the uuid once more
    set      the label's text; color (red, green, blue, or null); count faces, ascending: "u4" is
             base64 of little-endian uint32, "d4z" is base64 of zlib of the differences of those
    delete   the label's text
"""
import base64
import binascii
import json
import zlib
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import check_label
from mesh_msgs_hdf5.model.mesh import Color, Label

FORMAT = "mesh_msgs_hdf5 labels"
VERSION = 1
_START, _END = b'{"crc":"', b'",'
_BODY = len(_START) + 8 + len(_END)
_LONG = 64  # faces above which compression pays
_MAX_FACES = 1 << 28  # of a label of a mesh that is not known


def encoded(entry: Dict[str, Any]) -> bytes:
    """The line of an entry, with its newline."""
    body = json.dumps(entry, separators=(",", ":")).encode("ascii")
    return b"%s%08x%s%s\n" % (_START, zlib.crc32(body), _END, body[1:])


def decoded(line: bytes) -> Optional[Dict[str, Any]]:
    """The entry of a line without its newline; None if it is damaged."""
    if not line.startswith(_START) or line[_BODY - len(_END) : _BODY] != _END:
        return None
    body = b"{" + line[_BODY:]
    if b"%08x" % zlib.crc32(body) != line[len(_START) : _BODY - len(_END)]:
        return None
    try:
        entry = json.loads(body.decode("ascii"))
    except (ValueError, RecursionError):
        return None
    return entry if isinstance(entry, dict) else None


def pieces(line: bytes) -> List[bytes]:
    """A damaged line cut where another one starts in it: its newline may be what was damaged."""
    found = line.split(_START)
    return [piece for piece in [found[0]] + [_START + rest for rest in found[1:]] if piece]


def header(uuid: str, part: Optional[str], face_count: Optional[int]) -> Dict[str, Any]:
    """The first entry."""
    return {
        "journal": FORMAT,
        "version": VERSION,
        "uuid": uuid,
        "part": part,
        "faces": face_count,
    }


def owner_entry(owner: Dict[str, Any], uuid: str) -> Dict[str, Any]:
    """The entry that says who writes from here on."""
    return {"owner": owner, "uuid": uuid}


def edit_entry(text: str, label: Optional[Label]) -> Dict[str, Any]:
    """The entry that sets a label (faces ascending), or deletes it (None)."""
    if label is None:
        return {"delete": text}
    faces = np.ascontiguousarray(label.faces, "<u4")
    entry = {"set": text, "color": label.color, "count": len(faces)}
    if len(faces) <= _LONG:
        entry["u4"] = base64.b64encode(faces.tobytes()).decode("ascii")
    else:
        differences = np.diff(faces, prepend=np.zeros(1, "<u4"))
        packed = zlib.compress(differences.tobytes(), 1)
        entry["d4z"] = base64.b64encode(packed).decode("ascii")
    return entry


def edit_of(
    entry: Dict[str, Any], face_count: Optional[int]
) -> Optional[Tuple[str, Optional[Label]]]:
    """(text, label or None for a deletion) of an entry.

    None for an entry that is no edit this program can make: of another kind, or with a face that
    the mesh (of face_count faces, if that is known) does not have.
    """
    text = entry.get("set", entry.get("delete"))
    try:
        check_label("", text)
        if "delete" in entry:
            return text, None
        return text, Label(_faces(entry, face_count), _color(entry["color"]))
    except (AttributeError, KeyError, TypeError, ValueError, zlib.error, MapFileError):
        return None


def _faces(entry, face_count):
    count = entry["count"]
    limit = _MAX_FACES if face_count is None else face_count
    if not isinstance(count, int) or not 0 <= count <= limit:
        raise ValueError("count")
    if "u4" in entry:
        data = _unpacked(entry["u4"])
    else:
        inflate = zlib.decompressobj()
        # never more than the label may need, whatever the compressed bytes would become
        data = inflate.decompress(_unpacked(entry["d4z"]), 4 * count + 1)
    faces = np.frombuffer(data, "<u4")
    if "u4" not in entry:
        total = np.cumsum(faces, dtype=np.uint64)
        faces = total.astype("<u4")
        if len(total) and total[-1] >> np.uint64(32):
            raise ValueError("faces")
    if len(faces) != count or not _ascending(faces):
        raise ValueError("faces")
    if face_count is not None and count and faces[-1] >= face_count:
        raise ValueError("faces")
    faces = faces.astype(np.uint32)
    faces.setflags(write=False)
    return faces


def _ascending(faces):
    return bool((faces[1:] > faces[:-1]).all())


def _unpacked(text):
    try:
        return base64.b64decode(text.encode("ascii"), validate=True)
    except binascii.Error as error:
        raise ValueError("base64") from error


def _color(value) -> Optional[Color]:
    if value is None:
        return None
    red, green, blue = value
    for number in (red, green, blue):
        if type(number) is not int or not 0 <= number <= 255:
            raise ValueError("color")
    return red, green, blue
