"""The messages of mesh_msgs for what a map holds.

Each is made when it is asked for, from a map file that is read lazily. What a 1.x client knows is
as released: colors are bytes / 255 with alpha 1, material i has cluster i, textures are rgb8 (or
rgba8), texture coordinates are those of the file (v upwards).
"""
import math
from typing import Any, Dict, Hashable, List, Optional, Tuple

import genpy
import numpy as np
from mesh_msgs import arrays
from mesh_msgs.msg import (
    Feature,
    LayerInfo,
    LayerInfoArray,
    MeshFeatures,
    MeshMaterial,
    MeshTexture,
)
from sensor_msgs.msg import Image
from std_msgs.msg import ColorRGBA, Float32, Header

from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.layer_meaning import (
    ABOVE,
    AT_LEAST,
    NONE,
    OTHER,
    LayerMeaning,
    meaning_of,
)
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials

VERTICES, FACES, NORMALS = "vertices", "faces", "vertex_normals"
_ALL = (VERTICES, FACES, NORMALS)
_ENCODINGS = {3: "rgb8", 4: "rgba8"}


_COMPARISONS = {
    NONE: LayerInfo.NONE,
    ABOVE: LayerInfo.ABOVE,
    AT_LEAST: LayerInfo.AT_LEAST,
    OTHER: LayerInfo.OTHER,
}


def layer_info(name: str, meaning: LayerMeaning) -> LayerInfo:
    """What the costs of a layer mean, with their numbers."""
    return LayerInfo(
        name=name,
        layer_type=meaning.layer_type,
        unit=meaning.unit,
        infinity="lethal",
        comparison=_COMPARISONS[meaning.comparison],
        threshold=meaning.threshold,
        cost_limit=math.nan,
        lethal=meaning.lethal or 0,
        unknown=meaning.unknown or 0,
    )


class MapMessages:
    """The messages of one map.

    Args:
        source: a MapFile, or what has its interface.
        uuid: of the geometry, for every message.
        stamp: when the map was loaded, for every header but those of touch().
    """

    def __init__(self, source: Any, uuid: str, stamp: genpy.Time) -> None:
        self._source = source
        self.uuid = uuid
        self._frame_id = source.frame_id
        self._stamp = stamp
        self._stamps: Dict[Tuple[str, Hashable], genpy.Time] = {}
        self._carried: Dict[str, bool] = {}  # vertex attributes that were looked at
        self._layer_infos: Dict[str, Optional[LayerInfo]] = {}  # those looked at; None: it has none

    def touch(self, member: str, key: Hashable, stamp: genpy.Time) -> None:
        """From now on the member (vertex_costs, ...; key: its name or index) has this stamp."""
        self._stamps[member, key] = stamp

    def geometry(self, parts: Tuple[str, ...] = _ALL) -> arrays.MeshGeometryStamped:
        """parts: of VERTICES, FACES, NORMALS; the others stay empty and are not read."""
        none = np.zeros((0, 3), np.float32)
        found = {name: getattr(self._source, name) if name in parts else none for name in _ALL}
        if found[NORMALS] is None:
            found[NORMALS] = none
        return arrays.MeshGeometryStamped(
            header=self._header(), uuid=self.uuid, mesh_geometry=arrays.MeshGeometry(**found)
        )

    def vertex_colors(self) -> arrays.MeshVertexColorsStamped:
        """Without colors in the map: none."""
        return arrays.MeshVertexColorsStamped(
            header=self._header("vertex_colors"),
            uuid=self.uuid,
            mesh_vertex_colors=arrays.MeshVertexColors(rgba(self._source.vertex_colors)),
        )

    def vertex_costs(self, name: str) -> Optional[arrays.MeshVertexCostsStamped]:
        """One layer, or a vertex attribute of one column of which float32 holds each number; None
        for any other attribute: the message has no place for it."""
        try:
            costs = self._source.vertex_costs(name)
        except MapFileError as error:
            if error.code != "layer" or name not in self._source.vertex_attribute_names():
                raise
            values = self._source.vertex_attribute(name)
            with np.errstate(all="ignore"):
                costs = values.astype(np.float32)
                exact = ((costs.astype(np.longdouble) == values) | (values != values)).all()
            self._carried[name] = values.ndim == 1 and bool(exact)
            if not self._carried[name]:
                return None
        return arrays.MeshVertexCostsStamped(
            header=self._header("vertex_costs", name),
            uuid=self.uuid,
            type=name,
            mesh_vertex_costs=arrays.MeshVertexCosts(costs),
        )

    def vertex_cost_names(self) -> List[str]:
        """The names of all that vertex_costs() has a message for; layers first."""
        found = self._source.layer_names()
        for name in self._source.vertex_attribute_names():
            if name not in self._carried:
                try:
                    self.vertex_costs(name)
                except MapFileError:  # whoever asks for it is told
                    self._carried[name] = False
            found += [name] if self._carried[name] else []
        return found

    def layer_info(self) -> Optional[LayerInfoArray]:
        """What the values of those layers mean of which the map says it; None: of none."""
        names = self._source.layer_names()
        for name in names:
            if name not in self._layer_infos:
                self._layer_infos[name] = self._layer_info_of(name)
        layers = [info for info in map(self._layer_infos.get, names) if info is not None]
        if not layers:
            return None
        header = self._header("layer_info")
        return LayerInfoArray(header=header, uuid=self.uuid, layers=layers)

    def layer_replaced(self, name: str) -> bool:
        """To be called when the values of a layer are others; whether `layer_info` is, too."""
        before = self._layer_infos.pop(name, None)
        now = self._layer_infos[name] = self._layer_info_of(name)
        return before is not None or now is not None

    def _layer_info_of(self, name: str) -> Optional[LayerInfo]:
        meaning = meaning_of(self._source.layer_parameters(name))
        if meaning is None:
            return None
        if meaning.lethal is None or meaning.unknown is None:
            meaning = meaning.counted(self._source.vertex_costs(name))
        return layer_info(name, meaning)

    def face_costs(self, name: str) -> Optional[arrays.MeshFaceCostsStamped]:
        """A face attribute that is a cost (float32, one for each face); None for any other."""
        costs = self._source.face_attribute(name)
        if costs.dtype != np.float32 or costs.shape not in ((len(costs),), (len(costs), 1)):
            return None
        return arrays.MeshFaceCostsStamped(
            header=self._header("face_attributes", name),
            uuid=self.uuid,
            type=name,
            mesh_face_costs=arrays.MeshFaceCosts(costs.reshape(-1)),
        )

    def materials(self) -> arrays.MeshMaterialsStamped:
        """Without materials in the map: none."""
        coordinates = self._source.texture_coordinates
        return arrays.MeshMaterialsStamped(
            header=self._header("materials"),
            uuid=self.uuid,
            mesh_materials=materials_message(self._source.materials, coordinates),
        )

    def texture(self, index: int) -> MeshTexture:
        """One texture, the only one that is read."""
        image = texture_image(self._source.texture(index))
        image.header = self._header("textures", index)
        return MeshTexture(uuid=self.uuid, texture_index=index, image=image)

    def features(self) -> Optional[MeshFeatures]:
        """The texture features; None if the map has none."""
        features = self._source.features
        if features is None:
            return None
        return MeshFeatures(map_uuid=self.uuid, features=feature_list(features))

    def _header(self, member: str = "", key: Hashable = None) -> Header:
        stamp = self._stamps.get((member, key), self._stamp)
        return Header(stamp=stamp, frame_id=self._frame_id)


def rgba(rgb: Optional[np.ndarray]) -> np.ndarray:
    """(N, 3) uint8 as (N, 4) float32 from 0 to 1, alpha 1; None as (0, 4)."""
    if rgb is None:
        return np.zeros((0, 4), np.float32)
    colors = np.ones((len(rgb), 4), np.float32)
    np.divide(rgb, np.float32(255), out=colors[:, :3])
    return colors


def materials_message(
    materials: Optional[Materials], coordinates: Optional[np.ndarray]
) -> arrays.MeshMaterials:
    """A cluster for each material (in `wire_order`), with its faces in ascending order."""
    message = arrays.MeshMaterials(
        vertex_tex_coords=np.zeros((0, 2), np.float32) if coordinates is None else coordinates
    )
    if materials is None:
        return message
    count = len(materials.colors)
    order = np.argsort(materials.face_materials, kind="stable").astype(np.uint32)
    ends = np.cumsum(np.bincount(materials.face_materials, minlength=count))
    colors = rgba(materials.colors)
    for position, number in enumerate(wire_order(materials.texture_indices)):
        index = int(materials.texture_indices[number])
        faces = order[ends[number - 1] if number else 0 : ends[number]]
        message.clusters.append(arrays.MeshFaceCluster(face_indices=faces))
        # no texture is -1 in a file, and has_texture here: as uint32 it would be 4294967295
        message.materials.append(
            MeshMaterial(
                texture_index=index if index >= 0 else position,
                color=ColorRGBA(*colors[number]),
                has_texture=index >= 0,
            )
        )
    message.cluster_materials = list(range(count))
    return message


def wire_order(texture_indices: np.ndarray) -> List[int]:
    """The materials' numbers, in the order in which a message has them.

    The released RViz plugin does not look at has_texture: it makes an OGRE material named by
    texture_index of each material and finds it in a list by that index. An index that stands twice
    ends RViz, and so may one that is not the material's position. So the material of texture k is
    the k-th where that can be, and the others, in their order, fill the places that stay free: then
    the position of one without texture is no texture's index.
    """
    count = len(texture_indices)
    places: List[Optional[int]] = [None] * count
    rest = []
    for number, index in enumerate(texture_indices.tolist()):
        if 0 <= index < count and places[index] is None:
            places[index] = number
        else:
            rest.append(number)
    others = iter(rest)
    return [next(others) if number is None else number for number in places]


def texture_image(pixels: np.ndarray) -> Image:
    """(height, width, 3 or 4) uint8 as an rgb8 or rgba8 image without padding."""
    height, width, channels = pixels.shape
    return Image(
        height=height,
        width=width,
        encoding=_ENCODINGS[channels],
        step=channels * width,
        data=pixels.tobytes(),
    )


def cluster(text: str, label: Label) -> arrays.MeshFaceCluster:
    """A label with its faces."""
    return arrays.MeshFaceCluster(face_indices=label.faces, label=text)


def clusters(labels: Dict[str, Label]) -> List[arrays.MeshFaceCluster]:
    """All labels in their order."""
    return [cluster(text, label) for text, label in labels.items()]


def feature_list(features: Features) -> List[Feature]:
    """The places with their descriptors."""
    rows = zip(features.locations.tolist(), features.descriptors.tolist())
    found = []
    for (x, y, z), descriptor in rows:
        feature = Feature(descriptor=[Float32(number) for number in descriptor])
        feature.location.x, feature.location.y, feature.location.z = x, y, z
        found.append(feature)
    return found
