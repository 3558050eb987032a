"""A triangle mesh with everything that a map file keeps of it, as arrays."""
from dataclasses import dataclass, field
from typing import Any, Dict, Optional, Tuple

import numpy as np
from mesh_msgs.identity import geometry_uuid
from mesh_msgs.split_mesh import original_vertices

Color = Tuple[int, int, int]


@dataclass
class Materials:
    """What the faces are made of.

    colors: (M, 3) uint8 red, green, blue.
    texture_indices: (M,) int32, a key of Mesh.textures; -1 for a material without texture.
    face_materials: (F,) uint32, the material of each face, each below M.
    """

    colors: np.ndarray
    texture_indices: np.ndarray
    face_materials: np.ndarray


@dataclass
class Features:
    """Features found in the textures, with their places on the surface.

    locations: (N, 3) float32, meters in frame_id.
    descriptors: (N, D) float32.
    """

    locations: np.ndarray
    descriptors: np.ndarray


@dataclass
class Label:
    """A set of faces that has a name (the key in Mesh.labels; see label_names).

    faces: (K,) uint32, face indices, each once, in any order.
    color: red, green, blue from 0 to 255, or None.
    """

    faces: np.ndarray
    color: Optional[Color] = None


@dataclass
class Mesh:
    """One mesh as it stands in a map file.

    vertices: (V, 3) float32, meters in frame_id, REP 103 axes.
    faces: (F, 3) uint32, vertex indices, counter-clockwise seen from outside.
    vertex_normals: (V, 3) float32 or None.
    vertex_colors: (V, 3) uint8 red, green, blue, or None.
    vertex_costs: layer name -> (V,) float32; finite >= 0 is a cost, +inf is lethal, NaN is unknown.
    vertex_attributes: name -> (V,) or (V, C) of float or integer numbers of any width, which are no
        costs: class ids, intensities, features. Layers have other names.
    face_attributes: name -> (F,) or (F, C) of float or integer numbers of any width; costs of faces
        are (F,) float32.
    layer_parameters, vertex_parameters, face_parameters: name -> the parameters that this layer
        (attribute) was computed with (what json can write).
    texture_coordinates: (V, 2) float32 u, v (v upwards, as OBJ and OpenGL have it), or None.
    textures: index -> (height, width, 3) uint8 red, green, blue, or (height, width, 4) with alpha;
        row 0 is the top.
    materials: of the faces, or None.
    labels: text -> faces; a text "tree_1" is instance 1 of the class tree.
    features: or None.
    frame_id: the coordinate frame.
    origin: (x, y, z) float64 in meters; vertices + origin are the coordinates in crs. Keeps
        georeferenced maps near zero, where float32 is exact (REP 103).
    crs: the coordinate reference system of origin, e.g. "EPSG:25832"; "" if not known.
    source: where the mesh comes from (what json can write).
    seam_originals: (C,) uint32, or None: the last C vertices are copies of these, which are among
        the others, along the seams of textures. So this is a derived mesh, and its parent is the
        mesh without the copies (mesh_msgs.split_mesh).
    """

    vertices: np.ndarray
    faces: np.ndarray
    vertex_normals: Optional[np.ndarray] = None
    vertex_colors: Optional[np.ndarray] = None
    vertex_costs: Dict[str, np.ndarray] = field(default_factory=dict)
    frame_id: str = "map"
    source: Dict[str, Any] = field(default_factory=dict)
    layer_parameters: Dict[str, Dict[str, Any]] = field(default_factory=dict)
    face_attributes: Dict[str, np.ndarray] = field(default_factory=dict)
    face_parameters: Dict[str, Dict[str, Any]] = field(default_factory=dict)
    vertex_attributes: Dict[str, np.ndarray] = field(default_factory=dict)
    vertex_parameters: Dict[str, Dict[str, Any]] = field(default_factory=dict)
    texture_coordinates: Optional[np.ndarray] = None
    textures: Dict[int, np.ndarray] = field(default_factory=dict)
    materials: Optional[Materials] = None
    labels: Dict[str, Label] = field(default_factory=dict)
    features: Optional[Features] = None
    origin: Tuple[float, float, float] = (0.0, 0.0, 0.0)
    crs: str = ""
    seam_originals: Optional[np.ndarray] = None

    @property
    def uuid(self) -> str:
        """The version 5 UUID of vertices and faces (computed at each call)."""
        return geometry_uuid(self.vertices, self.faces)

    @property
    def parent_vertices(self) -> np.ndarray:
        """(V - C, 3): without the copies along seams."""
        copies = 0 if self.seam_originals is None else len(self.seam_originals)
        return self.vertices[: len(self.vertices) - copies]

    @property
    def parent_faces(self) -> np.ndarray:
        """(F, 3) uint32: with the originals for the copies along seams (computed at each call)."""
        if self.seam_originals is None:
            return self.faces
        originals = original_vertices(len(self.vertices), self.seam_originals)
        return originals.astype(np.uint32)[self.faces]

    @property
    def parent_uuid(self) -> str:
        """The UUID of the mesh without the copies along seams; "" if there are none (computed at
        each call)."""
        if self.seam_originals is None:
            return ""
        return geometry_uuid(self.parent_vertices, self.parent_faces)
