"""What the writers of all formats share: the files of an export, names, and what is left out."""
import hashlib
import os
import re
from dataclasses import dataclass, field
from typing import Any, Collection, Dict, Iterable, List

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.formats.base.images import png
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

_UNSAFE = re.compile(r"[^A-Za-z0-9_.-]")


@dataclass
class Export:
    """content: the bytes of the file; beside: name -> bytes of the files that it names; notes: what
    the format cannot take.
    """

    content: bytes = b""
    beside: Dict[str, bytes] = field(default_factory=dict)
    notes: List[str] = field(default_factory=list)

    def note(self, text: str, *values: Any) -> None:
        """Add a sentence; values are put into it by %."""
        self.notes.append(one_line(text % values if values else text))

    def leave_out(self, mesh: Mesh, format: str, *names: str) -> None:
        """A note for each of the members of a mesh (or their parts) that the format has no place
        for, where the mesh has it.
        """
        for name in names:
            value = getattr(mesh, name)
            number = _frame(value) if name == "frame_id" else _number(value)
            if number:
                hint = (
                    "; --layer NAME paints one into the colors"
                    if name == "vertex_costs" and format != "STL"
                    else ""
                )
                self.note(
                    "left out: %s, which %s does not have%s", MEANING[name] % number, format, hint
                )


# member of a mesh -> what it is, for a note; all that a format may have no place for
MEANING = {
    "vertex_normals": "%d normals",
    "vertex_colors": "%d vertex colors",
    "vertex_costs": "%d layers",
    "vertex_attributes": "%d vertex attributes",
    "face_attributes": "%d face attributes",
    "texture_coordinates": "%d texture coordinates",
    "textures": "%d textures",
    "materials": "%d materials",
    "labels": "%d labels",
    "features": "%d texture features",
    "origin": "the origin (%d coordinates)",
    "crs": "the coordinate reference system (%d letters)",
    "frame_id": "the frame %s",
}


def _frame(name: str) -> str:
    """Nothing of the one that is the default."""
    return "" if name == "map" else name


def _number(value: Any) -> int:
    if value is None:
        return 0
    if hasattr(value, "locations"):
        return len(value.locations)
    if hasattr(value, "face_materials"):
        return len(value.colors)
    if isinstance(value, tuple):  # the origin
        return len(value) if any(value) else 0
    return len(value)


def safe_name(text: str, taken: Collection[str], prefix: str = "") -> str:
    """The text in letters, digits, points and dashes, other than what is taken."""
    name = _UNSAFE.sub("_", text)[:100] or "_"
    name = prefix + name if prefix and name in taken else name
    number, result = 2, name
    while result in taken:
        result, number = "%s_%d" % (name, number), number + 1
    return result


def file_stem(path: PathLike) -> str:
    """What the names of files beside this one begin with: its own name without suffix, in letters
    that every program reads. A name that has others gets a hash, so that no two become one.
    """
    name = os.path.basename(os.path.realpath(os.fsdecode(path)))
    stem = os.path.splitext(name)[0]
    plain = _UNSAFE.sub("_", stem)[:100]
    if plain == stem and plain:
        return plain
    return "%s_%s" % (plain or "_", hashlib.sha256(os.fsencode(stem)).hexdigest()[:8])


def texture_files(path: PathLike, mesh: Mesh, export: Export) -> Dict[int, str]:
    """Put a PNG of each texture beside the file; returns texture index -> file name.

    Their names have the suffix, too: exports to several formats are of different maps, sometimes.
    """
    suffix = os.path.splitext(os.fsdecode(path))[1][1:]
    pattern = "%s_%s_texture_%%d.png" % (file_stem(path), suffix)
    names = {index: pattern % index for index in sorted(mesh.textures)}
    for index, name in names.items():
        export.beside[name] = png(mesh.textures[index])
    return names


def text_rows(pattern: str, table: np.ndarray) -> bytes:
    """A line of ASCII for each row of a table (N, C); pattern: one line, ending in a newline."""
    parts: List[bytes] = []
    for start in range(0, len(table), 1 << 15):
        block = table[start : start + (1 << 15)]
        parts.append((pattern * len(block) % tuple(block.reshape(-1).tolist())).encode("ascii"))
    return b"".join(parts)


def check_size(path: PathLike, size: int, format: str) -> None:
    """Refuse what has more bytes than four can count."""
    if size >= 1 << 32:
        raise MapFileError(
            "size",
            path,
            "a %s file holds at most 4 GiB, this would be %d bytes" % (format, size),
            "choose another format",
        )


def lines(texts: Iterable[str]) -> bytes:
    """ASCII, each text a line."""
    return "".join(text + "\n" for text in texts).encode("ascii")
