"""The materials and textures of a glTF file."""
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.material_list import NO_TEXTURE, WHITE, ImportedTextures
from mesh_msgs_hdf5.formats.base.remarks import Remark, about
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.gltf.gltf_file import GltfFile
from mesh_msgs_hdf5.formats.gltf.gltf_scene import to_srgb

_WEBP = "EXT_texture_webp"


class GltfMaterialReader:
    """Colors and images of the materials of a file."""

    def __init__(
        self,
        file: GltfFile,
        remarks: List[Remark],
        textures: ImportedTextures,
        report: ImportReport,
    ) -> None:
        self._file, self._report = file, report
        self.textures = textures
        # what index a mesh of our export had for an image
        self._wanted = {
            remark["image"]: remark["texture"]
            for remark in about(remarks, "texture", int)
            if type(remark.get("image")) is int and 0 <= remark["texture"] < 1 << 31
        }
        for image in sorted(self._wanted, key=lambda image: self._wanted[image]):
            if image in range(len(file.items("images"))):
                self._image(image)

    def chosen(
        self, face_materials: np.ndarray, keep_all: bool
    ) -> Tuple[List[Tuple[Any, int]], np.ndarray]:
        """(materials (color, texture index), the number (F,) of each face's).

        face_materials: (F,) as in the file, -1 for none; keep_all: also those that no face has.
        """
        count = len(self._file.items("materials"))
        used = np.unique(face_materials)
        if len(used) and used[-1] >= count:
            self._file.item("materials", int(used[-1]))  # refuses it
        rows = list(range(count)) if keep_all else [int(i) for i in used if i >= 0]
        place = np.full(count + 1, len(rows), np.int64)
        place[rows] = np.arange(len(rows))
        materials = [self._material(i) for i in rows]
        if len(used) and used[0] < 0:
            materials.append((WHITE, NO_TEXTURE))
        return materials, place[np.where(face_materials < 0, count, face_materials)]

    def _material(self, index):
        item = self._file.item("materials", index)
        shading = item.get("pbrMetallicRoughness", {})
        if not isinstance(shading, dict):
            self._file.damaged("pbrMetallicRoughness of material %d is no object", index)
        linear = self._file.numbers(shading, "baseColorFactor", [1.0, 1.0, 1.0, 1.0])
        color = tuple(int(value) for value in to_srgb(linear[:3]))
        texture = shading.get("baseColorTexture")
        if texture is None:
            return color, NO_TEXTURE
        if not isinstance(texture, dict):
            self._file.damaged("baseColorTexture of material %d is no object", index)
        if texture.get("texCoord", 0) != 0:
            self._report.note(
                "left out: the texture of material %d, which has coordinates of its own", index
            )
            return color, NO_TEXTURE
        if "KHR_texture_transform" in _object(texture.get("extensions")):
            self._report.note("material %d: moving and scaling of its texture is left out", index)
        source = self._source(self._file.item("textures", texture.get("index")))
        return color, NO_TEXTURE if source is None else self._image(source)

    def _source(self, texture: Dict[str, Any]) -> Optional[Any]:
        webp = _object(_object(texture.get("extensions")).get(_WEBP))
        return texture.get("source", webp.get("source"))

    def _image(self, index: Any) -> int:
        item = self._file.item("images", index)

        def read():
            if "bufferView" in item:
                return bytes(self._file.view(item["bufferView"])), ""
            return self._file.read_uri(item.get("uri"))

        return self.textures.add(
            ("image", index), "image %d" % index, read, self._wanted.get(index)
        )


def _object(value: Any) -> Dict[str, Any]:
    return value if isinstance(value, dict) else {}
