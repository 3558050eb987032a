"""Materials of an OBJ file: the MTL files that it names, and which faces have which."""
import re
from typing import Dict, List, NamedTuple, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.beside import Folder, shown
from mesh_msgs_hdf5.formats.base.material_list import (
    NO_TEXTURE,
    WHITE,
    ImportedTextures,
    byte_color,
)
from mesh_msgs_hdf5.formats.base.report import ImportReport

MAX_MTL_BYTES = 64 << 20
# options of map_Kd, with the most values that follow each; numbers may be fewer
_OPTIONS = {
    b"-blendu": 1,
    b"-blendv": 1,
    b"-bm": 1,
    b"-boost": 1,
    b"-cc": 1,
    b"-clamp": 1,
    b"-imfchan": 1,
    b"-mm": 2,
    b"-o": 3,
    b"-s": 3,
    b"-t": 3,
    b"-texres": 1,
    b"-type": 1,
}
_MOVING = (b"-o", b"-s", b"-t")
_OPAQUE = {b"d": 1.0, b"tr": 0.0}
_NUMBER = re.compile(rb"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")


class MtlMaterial(NamedTuple):
    """color: of Kd, or None; texture: the file that map_Kd names, or None."""

    color: Optional[Tuple[int, int, int]] = None
    texture: Optional[bytes] = None


def read_mtl_files(
    folder: Folder, names: List[bytes], report: ImportReport
) -> Dict[bytes, MtlMaterial]:
    """The materials of all files that lines mtllib name, by name, in their order."""
    found: Dict[bytes, MtlMaterial] = {}
    for name in dict.fromkeys(names):
        # one name with blanks, or several names
        several = name.split()
        for file in [name] if len(several) == 1 or folder.find(name)[0] else several:
            data, reason = folder.read(file, MAX_MTL_BYTES)
            if data is None:
                report.note("left out: materials of %s, which %s", shown(file), reason)
            else:
                _read_mtl(data, found, report)
    return found


def _read_mtl(data, found, report):
    name, there, ambient = None, set(), []
    left_out: Dict[str, List[bytes]] = {}  # what -> materials
    for line in data.replace(b"\\\n", b" ").replace(b"\\\r\n", b" ").splitlines():
        words = line.split(None, 1)
        if len(words) < 2:
            continue
        key, text = words[0].lower(), words[1].strip()
        what = ""
        if key == b"newmtl":
            name = text
            what = "an entry of its own (it is there twice: the last values count)"
            what = what if name in there else ""
            there.add(name)
            found.setdefault(name, MtlMaterial())
        elif name is None:
            continue
        elif key == b"kd":
            color, clamped = _color(text)
            what = "its color (Kd) beyond 0..1" if clamped else ""
            if color is None:
                report.note(
                    "material %s: its color (Kd) is not given as three numbers", shown(name)
                )
            found[name] = found[name]._replace(color=color)
        elif key == b"map_kd":
            found[name] = found[name]._replace(texture=_texture(name, text, report))
        elif key == b"map_ka":
            ambient.append(name)
        elif key in _OPAQUE and not _is_number(text.split()[-1], _OPAQUE[key]):
            what = "its transparency (d, Tr)"
        elif key == b"map_d":
            what = "its texture of transparency (map_d)"
        if what:
            left_out.setdefault(what, []).append(name)
    alone = [each for each in ambient if found[each].texture is None]
    if alone:  # most have it beside map_Kd
        left_out["its texture of ambient light (map_Ka), the only one"] = alone
    for what, names in left_out.items():
        text = "left out of %d materials: %s; the first is %s"
        report.note(text, len(set(names)), what, shown(names[0]))


def _is_number(word: bytes, value: float) -> bool:
    return bool(_NUMBER.match(word)) and float(word) == value


def _color(text):
    """(color or None, whether it was beyond 0..1) of three numbers, or one."""
    words = text.split()
    if not words or len(words) > 3 or not all(_NUMBER.match(word) for word in words):
        return None, False
    values = [float(word) for word in words]
    values = values if len(values) == 3 else values[:1] * 3
    return byte_color(values), min(values) < 0 or max(values) > 1


def _texture(material, text, report):
    """The file's name, which may have blanks, behind the options."""
    moved = False
    while text.startswith(b"-"):
        word, _, rest = text.partition(b" ")
        if word not in _OPTIONS:
            break
        moved |= word in _MOVING
        text = rest.lstrip()
        for i in range(_OPTIONS[word]):
            value, _, rest = text.partition(b" ")
            if _OPTIONS[word] > 1 and i and not _NUMBER.match(value):
                break
            text = rest.lstrip()
    if moved:
        report.note("material %s: moving and scaling of its texture is left out", shown(material))
    return text or None


class FaceMaterials(NamedTuple):
    """materials: (color, texture index) of each; polygons: (N,) the material of each polygon."""

    materials: List[Tuple[Tuple[int, int, int], int]]
    polygons: np.ndarray


def face_materials(
    uses: List[Tuple[int, bytes]],
    polygon_count: int,
    known: Dict[bytes, MtlMaterial],
    textures: ImportedTextures,
    keep_all: bool,
    report: ImportReport,
) -> FaceMaterials:
    """The materials of the polygons, in the order of the MTL files.

    uses: (number of polygons before it, name) of each line usemtl; keep_all: also those that no
    polygon has. A name that no file tells about is white, and so are polygons before the first.
    """
    name_of = np.full(polygon_count, -1, np.int64)
    used: Dict[bytes, int] = {}
    for i, (start, name) in enumerate(uses):
        end = uses[i + 1][0] if i + 1 < len(uses) else polygon_count
        if start < end:
            name_of[start:end] = used.setdefault(name, len(used))
    unknown = [name for name in used if name not in known]
    if unknown:
        report.note(
            "%d materials are in no file, and white: %s%s",
            len(unknown),
            ", ".join(shown(name) for name in unknown[:5]),
            ", ..." if len(unknown) > 5 else "",
        )
    names = [name for name in known if keep_all or name in used] + unknown
    place = {name: i for i, name in enumerate(names)}
    number = np.array([place[name] for name in used] + [len(names)], np.int64)
    materials = []
    for name in names:
        color, texture = known.get(name, MtlMaterial())
        index = NO_TEXTURE if texture is None else textures.add_file(texture)
        materials.append((color or WHITE, index))
    if (name_of < 0).any():
        materials.append((WHITE, NO_TEXTURE))
    return FaceMaterials(materials, number[name_of])
