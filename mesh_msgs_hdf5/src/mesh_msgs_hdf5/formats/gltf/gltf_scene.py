"""The triangles of a glTF scene, every instance moved to its place; y is up."""
from typing import Any, Collection, Dict, Iterator, List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.polygons import strip_triangles
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.scene import ScenePart, check_scene_size
from mesh_msgs_hdf5.formats.gltf.gltf_file import GltfFile
from mesh_msgs_hdf5.model.errors import MapFileError

TRIANGLES, STRIP, FAN = 4, 5, 6
_LARGEST = {"i1": 127, "u1": 255, "i2": 32767, "u2": 65535}
# attributes of our export: colors where viewers show the materials, v upwards where 1 - v is not it
VERTEX_COLOR, TEXTURE_V = "_VERTEX_COLOR", "_TEXCOORD_V"
_READ = ("POSITION", "NORMAL", "COLOR_0", "TEXCOORD_0")
_HARMLESS = ("KHR_mesh_quantization", "KHR_texture_transform", "KHR_lights_punctual")
_HARMLESS_KIND = ("KHR_materials_", "EXT_texture_webp")


def check_extensions(file: GltfFile) -> None:
    """Refuse a file that needs an extension which changes its geometry."""
    unknown = [
        name
        for name in file.items("extensionsRequired")
        if not isinstance(name, str)
        or name not in _HARMLESS
        and not name.startswith(_HARMLESS_KIND)
    ]
    if unknown:
        raise MapFileError(
            "format",
            file.path,
            "it needs the glTF extension %s, which is not read" % str(unknown[0])[:80],
            "export it without compression",
        )


def to_srgb(linear: np.ndarray) -> np.ndarray:
    """uint8 as screens have it of light from 0 to 1 (IEC 61966-2-1)."""
    light = np.clip(np.nan_to_num(np.asarray(linear, np.float64), nan=1.0), 0, 1)
    curved = 1.055 * np.power(light, 1 / 2.4) - 0.055
    return np.rint(255 * np.where(light <= 0.0031308, 12.92 * light, curved)).astype(np.uint8)


class SceneReader:
    """Reads the scene."""

    def __init__(
        self, file: GltfFile, report: ImportReport, attributes: Collection[str] = ()
    ) -> None:
        """attributes: those that are no layers, though they have one column."""
        self._file, self._report = file, report
        self._attributes = attributes
        self._left_out: Dict[str, int] = {}
        self._total = 0

    def parts(self) -> List[ScenePart]:
        """Every instance of every mesh of the scene, in the order of the nodes."""
        found = [
            part.moved(transform)
            for mesh, transform in self._instances()
            for part in self._primitives(mesh)
        ]
        for what, number in sorted(self._left_out.items()):
            self._report.note("left out: %s of %d primitives", what, number)
        for what in ("animations", "skins"):
            if self._file.items(what):
                self._report.note("left out: %d %s", len(self._file.items(what)), what)
        return found

    def _instances(self) -> Iterator[Tuple[Any, np.ndarray]]:
        file = self._file
        todo = [(index, np.eye(4)) for index in reversed(self._roots())]
        seen = set()
        while todo:
            index, above = todo.pop()
            node = file.item("nodes", index)
            if index in seen:
                file.damaged("node %d is in two places of the scene", index)
            seen.add(index)
            with np.errstate(all="ignore"):
                transform = above @ self._transform(node)
            if "mesh" in node:
                yield file.item("meshes", node["mesh"]), transform
            children = node.get("children", [])
            if not isinstance(children, list):
                file.damaged("the children of node %d are no list", index)
            todo += [(child, transform) for child in reversed(children)]

    def _roots(self) -> List[Any]:
        file = self._file
        if file.items("scenes"):
            roots = file.item("scenes", file.json.get("scene", 0)).get("nodes", [])
            if not isinstance(roots, list):
                file.damaged("the nodes of the scene are no list")
            if len(file.items("scenes")) > 1:
                self._report.note("left out: %d other scenes", len(file.items("scenes")) - 1)
            return roots
        below = set()
        for i in range(len(file.items("nodes"))):
            children = file.item("nodes", i).get("children", [])
            below.update(child for child in children if type(child) is int)
        return [i for i in range(len(file.items("nodes"))) if i not in below]

    def _transform(self, node):
        if "matrix" in node:
            columns = self._file.numbers(node, "matrix", [0.0] * 16)
            return columns.reshape(4, 4).T
        x, y, z, w = self._file.numbers(node, "rotation", [0.0, 0.0, 0.0, 1.0])
        result = np.eye(4)
        result[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        result[:3, :3] *= self._file.numbers(node, "scale", [1.0, 1.0, 1.0])
        result[:3, 3] = self._file.numbers(node, "translation", [0.0, 0.0, 0.0])
        return result

    def _primitives(self, mesh) -> List[ScenePart]:
        """Parts of one mesh; primitives with the same attributes are one."""
        primitives = mesh.get("primitives", [])
        if not isinstance(primitives, list):
            self._file.damaged("the primitives of a mesh are no list")
        if mesh.get("weights"):
            self._skip("morph targets", len(primitives))
        # by their attributes: (attributes, faces and materials of each primitive)
        found: Dict[Any, Tuple[Dict[str, Any], List[np.ndarray], List[np.ndarray]]] = {}
        for primitive in primitives:
            attributes = primitive.get("attributes") if isinstance(primitive, dict) else None
            if not isinstance(attributes, dict):
                self._file.damaged("a primitive has no attributes")
            faces = self._triangles(primitive, attributes)
            if faces is None:
                continue
            key = tuple(sorted((name, repr(value)) for name, value in attributes.items()))
            if key not in found:
                self._count(len(self._file.accessor(attributes["POSITION"])))
            self._count(len(faces))
            _, all_faces, materials = found.setdefault(key, (attributes, [], []))
            all_faces.append(faces)
            materials.append(np.full(len(faces), _material(primitive)))
        return [
            self._part(attributes, np.concatenate(faces), np.concatenate(materials))
            for attributes, faces, materials in found.values()
        ]

    def _count(self, number):
        self._total += number
        check_scene_size(self._file.path, self._total)

    def _triangles(self, primitive, attributes) -> Optional[np.ndarray]:
        """(F, 3) int64 below the number of positions, or None."""
        file, mode = self._file, primitive.get("mode", TRIANGLES)
        if mode not in (TRIANGLES, STRIP, FAN) or isinstance(mode, bool):
            self._skip("points or lines")
            return None
        if "POSITION" not in attributes:
            self._skip("faces without positions")
            return None
        count = len(file.accessor(attributes["POSITION"]))
        if "indices" in primitive:
            index = file.accessor(primitive["indices"])
            if index.dtype.kind != "u" or index.shape[1] != 1:
                file.damaged("the indices of a primitive are no whole numbers")
            index = index[:, 0].astype(np.int64)
            wrong = np.flatnonzero(index >= count)
            if len(wrong):
                raise MapFileError(
                    "index",
                    file.path,
                    "face %d of a primitive refers to vertex %d of %d; %d corners do so"
                    % (wrong[0] // 3, index[wrong[0]], count, len(wrong)),
                    "repair the mesh where it was made",
                )
        else:
            index = np.arange(count)
        return _as_triangles(index, mode)

    def _part(self, attributes, faces, materials) -> ScenePart:
        read = self._read
        position = read(attributes, "POSITION", (3,))
        part = ScenePart(position, faces, materials)
        rows = len(position)
        part.normals = read(attributes, "NORMAL", (3,), rows)
        colors = read(attributes, "COLOR_0", (3, 4), rows)
        if colors is not None:
            part.colors = to_srgb(colors[:, :3])
            if colors.shape[1] == 4 and (colors[:, 3] != 1).any():
                self._skip("the alpha of colors")
        coordinates = read(attributes, "TEXCOORD_0", (2,), rows)
        if coordinates is not None:
            # v counts downwards in glTF
            up = 1.0 - coordinates[:, 1].astype(np.float64)
            part.coordinates = np.stack([coordinates[:, 0], up.astype(np.float32)], axis=1)
        for name in attributes:
            if name == VERTEX_COLOR:
                values = self._file.accessor(attributes[name])
                if part.colors is None and values.shape == (rows, 4) and values.dtype == np.uint8:
                    part.colors = np.ascontiguousarray(values[:, :3])
            elif name == TEXTURE_V and part.coordinates is not None:
                values = self._file.accessor(attributes[name])
                if values.shape == (rows, 1) and values.dtype == np.float32:
                    part.coordinates[:, 1] = values[:, 0]
            elif name.startswith("_"):
                values = self._file.accessor(attributes[name])
                if len(values) == rows and (name in self._attributes or values.shape[1] > 1):
                    part.attributes[name] = values
                elif values.shape == (rows, 1):
                    part.layers[name] = _as_float(values, False)[:, 0]
                else:
                    self._skip("attribute %s" % name[:40])
            elif name not in _READ and name != "TANGENT":
                self._skip("attribute %s" % name[:40])
        return part

    def _read(self, attributes, name, widths, rows=None) -> Optional[np.ndarray]:
        """(N, C) float32 of an attribute; whole numbers as the file says, scaled or as they are."""
        if name not in attributes:
            return None
        values = self._file.accessor(attributes[name])
        if values.shape[1] not in widths or rows is not None and len(values) != rows:
            self._file.damaged(
                "%s has the shape %s, not that of the %s positions", name, list(values.shape), rows
            )
        normalized = self._file.item("accessors", attributes[name]).get("normalized") is True
        return _as_float(values, normalized)

    def _skip(self, what, number=1):
        self._left_out[what] = self._left_out.get(what, 0) + number


def _material(primitive):
    index = primitive.get("material", -1)
    return index if type(index) is int else -1


def _as_triangles(index: np.ndarray, mode: int) -> np.ndarray:
    """(F, 3) of the corners of a list, a strip or a fan; what is left over is no triangle."""
    if mode == TRIANGLES:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if len(index) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == FAN:
        return np.stack([index[1:-1], index[2:], np.full(len(index) - 2, index[0])], axis=1)
    return strip_triangles(index)


def _as_float(values: np.ndarray, normalized: bool) -> np.ndarray:
    kind = values.dtype.str.lstrip("<|")
    result = np.ascontiguousarray(values, dtype=np.float32)
    if normalized and kind in _LARGEST:
        result = np.maximum(values.astype(np.float64) / _LARGEST[kind], -1).astype(np.float32)
    return result
