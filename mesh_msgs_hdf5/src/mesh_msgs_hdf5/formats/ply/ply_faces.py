"""What the faces of a PLY file have besides corners: colors, numbers, textures, labels."""
from typing import Any, Collection, Dict, List, Optional, Set, Tuple

import numpy as np

from mesh_msgs_hdf5.checks.check import MAX_TEXTURE_INDEX
from mesh_msgs_hdf5.formats.base.beside import Folder
from mesh_msgs_hdf5.formats.base.corners import with_corner_coordinates
from mesh_msgs_hdf5.formats.base.material_list import (
    NO_TEXTURE,
    WHITE,
    ImportedTextures,
    give_materials,
)
from mesh_msgs_hdf5.formats.base.options import Options
from mesh_msgs_hdf5.formats.base.polygons import Triangles
from mesh_msgs_hdf5.formats.base.remarks import (
    NUMBERS,
    Remark,
    about,
    add_label,
    color_of,
    parameters_of,
)
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.values import add_attribute, colors_or_none
from mesh_msgs_hdf5.formats.ply.ply_file import Element, PlyFile, columns
from mesh_msgs_hdf5.model.errors import PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

CORNERS = ("vertex_indices", "vertex_index")
FACE_COLORS = "face_colors"
TEXTURE_FILE = "TextureFile "
SEAMS = ("seam", "original")  # an element of our export, and its property: see Mesh.seam_originals
_RGB = ("red", "green", "blue")


class FaceReader:
    """Takes the properties of the element face into a mesh.

    used: names of those that are done with.
    """

    def __init__(
        self,
        path: PathLike,
        file: PlyFile,
        triangles: Triangles,
        remarks: List[Remark],
        options: Options,
        report: ImportReport,
    ) -> None:
        self._path, self._file, self._face = path, file, file.elements["face"]
        self._triangles, self._remarks = triangles, remarks
        self._options, self._report = options, report
        self.used: Set[str] = set(CORNERS)

    def take(self, mesh: Mesh) -> Mesh:
        """The mesh with everything that its faces have; seams may have been split."""
        mesh = self._take_corner_coordinates(mesh)
        self._take_materials(mesh)
        self._take_labels(mesh)
        self._take_attributes(mesh)
        return mesh

    def _take_corner_coordinates(self, mesh):
        """texcoord: u and v of each corner, as MeshLab writes them."""
        if "texcoord" not in self._face.lists or mesh.texture_coordinates is not None:
            return mesh
        self.used.add("texcoord")
        numbers, values = self._face.lists["texcoord"]
        counts = next(self._face.lists[name] for name in CORNERS if name in self._face.lists)[0]
        fits = numbers == 2 * counts
        if "texnumber" in self._face.values:
            fits &= self._face.values["texnumber"] >= 0
        known = np.repeat(fits, counts)
        found = np.zeros((len(known), 2), np.float32)
        with np.errstate(over="ignore"):
            found[known] = values[np.repeat(fits, numbers)].reshape(-1, 2)
        split = self._options.split_seams is not False
        return with_corner_coordinates(mesh, self._triangles, found, known, split, self._report)

    def _take_materials(self, mesh):
        own = about(self._remarks, "material", int)
        images = about(self._remarks, "texture", int)
        files = [c[len(TEXTURE_FILE) :] for c in self._file.comments if c.startswith(TEXTURE_FILE)]
        useful = mesh.texture_coordinates is not None
        exact = bool(own or images)
        textures = ImportedTextures(Folder(self._path), self._report, wanted=useful or exact)
        if exact:
            self._take_own_materials(mesh, own, images, textures)
        elif files and useful:
            indices = [textures.add_file(_file_name(name)) for name in files]
            give_materials(mesh, *self._by_texture(indices), textures)
        elif files:
            self._report.note("left out: %d textures, for want of coordinates", len(files))
        if files:
            self.used.add("texnumber")

    def _by_texture(self, indices):
        """(materials, face_materials) with a white material for each texture file."""
        materials = [(WHITE, index) for index in indices]
        if "texnumber" not in self._face.values:
            if len(indices) > 1:
                self._report.note(
                    "all faces have the first of %d textures: there is no property texnumber",
                    len(indices),
                )
            return materials, np.zeros(len(self._triangles.faces), np.uint32)
        numbers = self._triangles.of_polygons(self._face.values["texnumber"])
        without = ~((numbers >= 0) & (numbers < len(indices)))
        wrong = np.flatnonzero(without & (numbers != NO_TEXTURE))
        if len(wrong):
            self._report.note(
                "the texture of %d faces was left out: texnumber %g of face %d, but there are %d "
                "texture files",
                len(wrong),
                numbers[wrong[0]],
                wrong[0],
                len(indices),
            )
        if without.any():
            materials.append((WHITE, NO_TEXTURE))
        return materials, np.where(without, len(indices), numbers).astype(np.uint32)

    def _take_own_materials(self, mesh, own, images, textures):
        """What our export wrote: remarks, and the property material."""
        index = {NO_TEXTURE: NO_TEXTURE}
        for remark in images:
            file, key = remark.get("file"), remark["texture"]
            if isinstance(file, str) and 0 <= key <= MAX_TEXTURE_INDEX:
                index[key] = textures.add_file(file, wanted=key)
        own = sorted(own, key=lambda remark: remark["material"])
        materials = [
            (color_of(remark) or WHITE, index.get(_texture_of(remark), NO_TEXTURE))
            for remark in own
        ]
        numbers = self._face.values.get("material")
        sound = [remark["material"] for remark in own] == list(range(len(own)))
        if own and numbers is not None and sound and (numbers < len(own)).all():
            numbers = self._triangles.of_polygons(numbers)
            if (numbers >= 0).all():
                self.used.add("material")
                give_materials(mesh, materials, numbers, textures, exact=True)
                return
        if own:
            self._report.note("left out: %d materials whose remarks are damaged", len(own))
        mesh.textures = textures.images

    def _take_labels(self, mesh):
        # by property: (faces by the number in it, those numbers)
        ordered: Dict[str, Tuple[np.ndarray, np.ndarray]] = {}
        for remark in about(self._remarks, "label"):
            name, value = remark.get("property"), remark.get("value")
            if not isinstance(name, str) or not isinstance(value, int):
                continue
            if name not in self._face.values or not 0 < value < 1 << 31:
                continue
            if name not in ordered:
                self.used.add(name)
                values = self._triangles.of_polygons(self._face.values[name])
                order = np.argsort(values, kind="stable")
                ordered[name] = order, values[order]
            order, values = ordered[name]
            start, end = (np.searchsorted(values, value, side) for side in ("left", "right"))
            add_label(self._path, mesh, remark, order[start:end], self._report)

    def _take_attributes(self, mesh):
        kinds = {p.name: p.type for p in self._face.properties if not p.count}
        for remark in about(self._remarks, "face_attribute"):
            self._take_own_attribute(mesh, remark, kinds)
        if set(_RGB) <= set(kinds) - self.used:
            self.used |= set(_RGB)
            colors = colors_or_none(
                columns(self._face, _RGB), {kinds[name] for name in _RGB}, self._report, "face"
            )
            if colors is not None:
                values = self._triangles.of_polygons(colors)
                add_attribute(self._path, mesh, "face", FACE_COLORS, values, self._report)
                self.used |= {"alpha"} if self._is_opaque() else set()
        for name in kinds:
            if name not in self.used and name not in ("flags", "alpha"):
                values = self._face.typed(name)
                if values.dtype != np.dtype(kinds[name]).newbyteorder("="):
                    continue  # an ASCII file with fractions where it announces whole numbers
                self.used.add(name)
                values = self._triangles.of_polygons(values)
                add_attribute(self._path, mesh, "face", name, values, self._report)

    def _take_own_attribute(self, mesh, remark, kinds):
        values = own_attribute(self._face, remark, kinds)
        if values is None:
            return
        self.used |= set(remark["properties"])
        add_attribute(
            self._path,
            mesh,
            "face",
            remark["face_attribute"],
            self._triangles.of_polygons(values),
            self._report,
            parameters_of(remark),
        )

    def _is_opaque(self):
        alpha = self._face.values.get("alpha")
        return alpha is not None and bool((alpha == 255).all())


def own_attribute(element: Element, remark: Remark, kinds: Collection[str]) -> Optional[np.ndarray]:
    """(N,) or (N, C) of the attribute that our export says is in these properties of an element;
    None where they do not fit. kinds: the names of the plain properties.
    """
    names = remark.get("properties")
    if not isinstance(names, list) or not all(isinstance(n, str) and n in kinds for n in names):
        return None
    if remark.get("type") not in NUMBERS or not names:
        return None
    kind = np.dtype(remark["type"])
    values = columns(element, names)
    if kind.itemsize == 8 and kind.kind in "iu":  # two halves, the lower one first
        if len(names) % 2 or values.dtype.kind not in "iu":
            return None
        values = np.ascontiguousarray(values, "<u4").view("<" + kind.str[1:])
    values = values.astype(kind)
    return values[:, 0] if remark.get("rank") == 1 and values.shape[1] == 1 else values


def _file_name(text):
    """The bytes of a name that stands in a header, which was decoded as Latin-1."""
    return text.strip().encode("latin-1")


def _texture_of(remark: Remark) -> Any:
    texture = remark.get("texture")
    return texture if isinstance(texture, int) else NO_TEXTURE
