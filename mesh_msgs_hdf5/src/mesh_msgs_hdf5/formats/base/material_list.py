"""Collects the materials and textures of a mesh file while it is read."""
from typing import Any, Callable, Dict, Hashable, List, Optional, Set, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.beside import Folder, shown
from mesh_msgs_hdf5.formats.base.images import MAX_PIXELS, ImageError, decoded
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model.mesh import Materials, Mesh

WHITE = (255, 255, 255)
NO_TEXTURE = -1


class ImportedTextures:
    """Images by the index under which a mesh keeps them; each file is read once.

    wanted: False if no image is of any use, because there are no texture coordinates.
    """

    def __init__(self, folder: Folder, report: ImportReport, wanted: bool = True) -> None:
        self._folder, self._report, self._wanted = folder, report, wanted
        self.images: Dict[int, np.ndarray] = {}
        self._index: Dict[Hashable, int] = {}
        self._unwanted: Set[Hashable] = set()
        self._pixels = 0

    def add_file(self, name: str, wanted: Optional[int] = None) -> int:
        """The index of the image in a file beside the mesh; -1 with a note if there is none."""
        found, _ = self._folder.find(name)
        return self.add(
            ("file", found or name),
            "texture %s" % shown(name),
            lambda: self._folder.read(name),
            wanted,
        )

    def add(
        self,
        key: Hashable,
        what: str,
        read: Callable[[], Tuple[Optional[bytes], str]],
        wanted: Optional[int] = None,
    ) -> int:
        """The index of an image known by this key.

        read: its bytes, or (None, why not); wanted: the index it is to have.
        """
        if not self._wanted:
            self._unwanted.add(key)
            return NO_TEXTURE
        if key not in self._index:
            image = self._image(what, read)
            index = NO_TEXTURE
            if image is not None:
                index = wanted if wanted is not None and wanted not in self.images else None
                index = max(self.images, default=-1) + 1 if index is None else index
                self.images[index] = image
            self._index[key] = index
        return self._index[key]

    def note_unwanted(self) -> None:
        """Say how many images were left out because there is no place on them for the faces."""
        if self._unwanted:
            self._report.note("left out: %d textures, for want of coordinates", len(self._unwanted))

    def _image(self, what, read):
        data, reason = read()
        if data is not None:
            try:
                image = decoded(data)
                self._pixels += image.shape[0] * image.shape[1]
                if self._pixels <= MAX_PIXELS:
                    return image
                reason = "would be more than %d pixels with those before it" % MAX_PIXELS
            except ImageError as error:
                reason = str(error)
        self._report.note("left out: %s %s", what, reason)
        return None


def give_materials(
    mesh: Mesh,
    materials: List[Tuple[Any, int]],
    face_materials: np.ndarray,
    textures: ImportedTextures,
    exact: bool = False,
) -> None:
    """Put materials (color, texture index) into the mesh, and the images.

    exact: also those that say nothing, white ones without textures.
    """
    mesh.textures = textures.images
    textures.note_unwanted()
    if not exact and all(material == (WHITE, NO_TEXTURE) for material in materials):
        return
    mesh.materials = Materials(
        np.array([color for color, _ in materials], np.uint8).reshape(-1, 3),
        np.array([index for _, index in materials], np.int32),
        np.ascontiguousarray(face_materials, dtype=np.uint32),
    )


def byte_color(values: Any) -> Tuple[int, int, int]:
    """(red, green, blue) from 0 to 255 of numbers from 0 to 1."""
    values = np.nan_to_num(np.asarray(values, dtype=np.float64)[:3], nan=1.0)
    return tuple(int(value) for value in np.rint(np.clip(values, 0, 1) * 255))  # type: ignore
