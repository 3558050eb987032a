"""Materials of COLLADA files of ours, as they were: COLLADA has a color or a texture, not both, and
numbers of neither. Remarks in an <extra> tell, which other programs skip."""
import re
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Tuple
from xml.sax.saxutils import escape, unescape

import numpy as np

from mesh_msgs_hdf5.formats.base.material_list import NO_TEXTURE, WHITE, ImportedTextures
from mesh_msgs_hdf5.formats.base.remarks import (
    Remark,
    about,
    color_list,
    color_of,
    parsed_remarks,
    remark_texts,
)
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model.errors import PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

_PROFILE = '<extra><technique profile="mesh_tools">'
_REMARK = re.compile(rb"<remark>([^<]*)</remark>")
_NAME = re.compile(r"material_(\d{1,9})")
Material = Tuple[Any, int]


def own_materials_extra(path: PathLike, mesh: Mesh, files: Mapping[int, str]) -> List[str]:
    """Lines at the end of a document; files: texture index -> name."""
    remarks: List[Remark] = [{"texture": index, "file": name} for index, name in files.items()]
    if mesh.materials is not None:
        for i, (color, index) in enumerate(
            zip(mesh.materials.colors, mesh.materials.texture_indices.tolist())
        ):
            remark = {"material": i, "color": color_list(color)}
            remarks.append(dict(remark, texture=index) if index >= 0 else remark)
    if not remarks:
        return []
    texts = ["<remark>%s</remark>" % escape(text) for text in remark_texts(path, remarks)]
    return [_PROFILE, *texts, "</technique></extra>"]


class OwnMaterials(NamedTuple):
    """materials: (color, texture index) of each; faces: (F,) the number of each face's."""

    materials: List[Material]
    faces: np.ndarray


def own_materials(
    data: bytes,
    names: List[str],
    face_materials: np.ndarray,
    textures: ImportedTextures,
    report: ImportReport,
) -> Optional[OwnMaterials]:
    """What a document of ours says of the materials; None where it does not, or that is not so any
    more.

    names: of the materials of the scene that face_materials (F,) are the numbers of.
    """
    start = data.rfind(_PROFILE.encode())
    if start < 0:
        return None
    texts = _REMARK.findall(data, start)
    remarks = parsed_remarks((unescape(text.decode("utf-8", "replace")) for text in texts), report)
    own = sorted(about(remarks, "material", int), key=lambda remark: remark["material"])
    numbers = np.array([_number(name) for name in names], np.int64)
    sound = [remark["material"] for remark in own] == list(range(len(own)))
    of_faces = numbers[face_materials]
    if not own or not sound or not ((of_faces >= 0) & (of_faces < len(own))).all():
        return None
    index: Dict[Any, int] = {}
    for remark in about(remarks, "texture", int):
        if isinstance(remark.get("file"), str) and 0 <= remark["texture"] < 1 << 31:
            index[remark["texture"]] = textures.add_file(remark["file"], wanted=remark["texture"])
    materials = [
        (color_of(remark) or WHITE, index.get(_texture(remark), NO_TEXTURE)) for remark in own
    ]
    return OwnMaterials(materials, of_faces)


def _texture(remark: Remark) -> Any:
    texture = remark.get("texture")
    return texture if isinstance(texture, int) else NO_TEXTURE


def _number(name: str) -> int:
    found = _NAME.fullmatch(name)
    return int(found[1]) if found else -1
