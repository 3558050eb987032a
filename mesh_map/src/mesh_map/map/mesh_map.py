"""The mesh map: one geometry and the cost layers on it."""

from typing import Any, Optional

from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.costs.layer_changes import LayerChange
from mesh_map.costs.layered_costs import LayeredCosts
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.map.queries import SurfaceQueries

__all__ = ["COMBINED_COSTS", "LayerChange", "MeshMap", "PlanningCosts"]


class MeshMap(LayeredCosts):
    """A triangle mesh with cost layers. All arrays are read-only.

    What belongs to layers and their costs is in the base class.

    Attributes:
        geometry: the mesh; may be shared with other maps.
        contents: what else is in the map file (labels, stored layers, face attributes): a
            mesh_msgs_hdf5 MapFile or what has its methods; None where there is none.
    """

    def __init__(
        self,
        vertices: Any,
        faces: Any,
        vertex_normals: Optional[Any] = None,
        frame_id: str = "map",
        uuid: str = "",
        *,
        origin: Any = (0.0, 0.0, 0.0),
    ) -> None:
        """A map of a mesh of its own; arguments and errors are those of MeshGeometry."""
        geometry = MeshGeometry(vertices, faces, vertex_normals, frame_id, uuid, origin=origin)
        self._begin(geometry)

    @classmethod
    def of(cls, geometry: MeshGeometry, contents: Any = None) -> "MeshMap":
        """A map without layers of a mesh that may be shared: nothing of it is computed again."""
        made = cls.__new__(cls)
        made._begin(geometry, contents)
        return made

    def _begin(self, geometry: MeshGeometry, contents: Any = None) -> None:
        super().__init__(geometry)
        self.contents = contents
        self._queries: Optional[SurfaceQueries] = None

    # What is asked for most, so that callers need not reach through.
    vertices = property(lambda self: self.geometry.vertices)
    faces = property(lambda self: self.geometry.faces)
    origin = property(lambda self: self.geometry.origin)
    frame_id = property(lambda self: self.geometry.frame_id)
    uuid = property(lambda self: self.geometry.uuid)
    topology = property(lambda self: self.geometry.topology)
    face_normals = property(lambda self: self.geometry.face_normals)
    faces_without_area = property(lambda self: self.geometry.faces_without_area)
    vertex_normals = property(lambda self: self.geometry.vertex_normals)
    spatial_index = property(lambda self: self.geometry.spatial_index)
    report = property(lambda self: self.geometry.report)
    closest_face = property(lambda self: self.geometry.closest_face)
    nearest_vertex = property(lambda self: self.geometry.nearest_vertex)

    @property
    def queries(self) -> SurfaceQueries:
        """Questions about places on the surface: neighborhoods, costs, ways."""
        if self._queries is None:
            self._queries = SurfaceQueries(self)
        return self._queries
