"""Questions about a map: what is around, what carries a point, what it costs there."""

from functools import cached_property, partial
from typing import Any, Callable, NamedTuple, Optional

import numpy as np

from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.errors import MeshMapError
from mesh_map.base.query_arguments import (
    checked_distance,
    number,
    one_each,
    points_array,
    whole_number,
)
from mesh_map.geometry.surface import interpolate, interpolate_directions
from mesh_map.geometry.topology import NO_EDGE
from mesh_map.map.attributes import MAX, MeshAttributes, face_costs
from mesh_map.map.footprint import (
    Footprint,
    FootprintCost,
    FootprintCosts,
    FootprintVertices,
    pose_rows,
)
from mesh_map.map.path_cost import PathCost, path_cost
from mesh_map.spatial.hits import SurfacePoint, SurfacePoints

Inside = Callable[[np.ndarray], np.ndarray]

MAX_DISTANCE = 0.4  # meters; that of the released planners and controller


class PointCosts(NamedTuple):
    """Costs at N points.

    costs: (N,) float64: +inf lethal, NaN unknown or off the map.
    points: SurfacePoints, the points of the surface that carry them.
    """

    costs: np.ndarray
    points: SurfacePoints


class SurfaceQueries:
    """Questions about a mesh, and about its costs. Any thread may ask at any time.

    Arguments of all questions about costs:
        costs: (V,) float32, >= 0, +inf lethal, NaN unknown: those of one snapshot, such as
            MeshMap.planning_costs().costs, for questions that belong together; None for the
            combined costs of the map as they are now.
        max_distance: meters from the surface, on both sides of it, at which a point is still on the
            map.
        normal, max_angle: both or none: only faces count whose normal is within this angle
            (radians, 0 to pi) of this direction (3,): of two storeys, the one whose floor is below.

    Neighborhoods are indices, (N,) uint32, ascending. Arguments that are no index raise IndexError.

    Attributes:
        geometry: MeshGeometry.
        vertices, faces, topology: of it.
        walker: walks over the surface; one for all who share the geometry.
    """

    def __init__(self, source: Any) -> None:
        """Args:
        source: a MeshMap, or a MeshGeometry where no costs are needed but those given.
        """
        self._map = source if hasattr(source, "geometry") else None
        self.geometry = source if self._map is None else source.geometry
        self.vertices = self.geometry.vertices
        self.faces = self.geometry.faces

    topology = property(lambda self: self.geometry.topology)
    walker = property(lambda self: self.geometry.walker)

    @cached_property
    def attributes(self) -> MeshAttributes:
        """Named attributes of vertices and faces; those of the map file are there."""
        contents = getattr(self._map, "contents", None)
        return MeshAttributes(len(self.vertices), len(self.faces), contents)

    def neighbors_of_vertex(self, vertex: int) -> np.ndarray:
        """The vertices that an edge connects with this one."""
        return self.topology.neighbors_of(_index(vertex, self.topology.vertex_count, "vertex"))

    def faces_of_vertex(self, vertex: int) -> np.ndarray:
        """The faces around a vertex: its ring."""
        return self.topology.faces_of(_index(vertex, self.topology.vertex_count, "vertex"))

    def faces_of_edge(self, edge: int) -> np.ndarray:
        """The faces that meet in an edge, degenerate ones excepted."""
        edge = _index(edge, self.topology.edge_count, "edge")
        offsets = self.topology.edge_face_offsets
        return self.topology.edge_faces[offsets[edge] : offsets[edge + 1]]

    def neighbors_of_face(self, face: int) -> np.ndarray:
        """The faces that share an edge with this one: all of them, also where more than two meet,
        duplicates included. A degenerate face has none.
        """
        face = _index(face, self.topology.face_count, "face")
        edges = self.topology.face_edges[face]
        if NO_EDGE in edges:
            return np.zeros(0, np.uint32)
        rows = [self.faces_of_edge(edge) for edge in edges]
        return _without(np.unique(np.concatenate(rows)), face)

    def ring_of_face(self, face: int) -> np.ndarray:
        """The faces that share a vertex with this one."""
        face = _index(face, self.topology.face_count, "face")
        rows = [self.topology.faces_of(vertex) for vertex in self.faces[face]]
        return _without(np.unique(np.concatenate(rows)), face)

    def k_ring(self, vertex: int, k: int) -> np.ndarray:
        """The vertices that at most k edges connect with this one, which is among them."""
        return self._grown(vertex, whole_number(k, "k"), None)

    def radius_neighborhood(self, vertex: int, radius: float) -> np.ndarray:
        """The vertices that are reached from this one over edges through vertices that are all
        nearer to it than the radius (meters, Euclidean); it is among them. What the layers call the
        neighborhood of a vertex.
        """
        reach = number(radius, "radius")
        if not reach > 0.0:
            raise ValueError("the radius has to be above 0, not %g" % reach)
        vertex = _index(vertex, self.topology.vertex_count, "vertex")
        center = self.vertices[vertex].astype(np.float64)

        def is_inside(others: np.ndarray) -> np.ndarray:
            gaps = self.vertices[others] - center
            return (gaps[:, 0] ** 2 + gaps[:, 1] ** 2) + gaps[:, 2] ** 2 < reach * reach

        return self._grown(vertex, self.topology.vertex_count, is_inside)

    def _grown(self, vertex: int, rings: int, is_inside: Optional[Inside]) -> np.ndarray:
        """Ring by ring, through vertices that are inside."""
        count = self.topology.vertex_count
        newest = np.array([_index(vertex, count, "vertex")], np.uint32)
        seen = np.zeros(count, np.bool_)
        seen[newest] = True
        found = [newest]
        for _ in range(rings):
            newest = np.unique(self.topology.neighbors[self.topology.neighbor_places(newest)])
            newest = newest[~seen[newest]]
            seen[newest] = True
            if is_inside is not None:
                newest = newest[is_inside(newest)]
            if not len(newest):
                break
            found.append(newest)
        return np.sort(np.concatenate(found))

    def carry(
        self,
        points: Any,
        *,
        max_distance: float = MAX_DISTANCE,
        normal: Optional[Any] = None,
        max_angle: Optional[float] = None,
    ) -> SurfacePoints:
        """The points of the surface that carry points: the nearest ones, of faces with an area.

        Args:
            points: (N, 3) meters; one that is not finite finds nothing.
            max_distance, normal, max_angle: see the class; normal may be (N, 3), too.
        Raises:
            ValueError: another shape, a distance that is negative or NaN, or a bad angle.
        """
        return self.geometry.spatial_index.closest_batch(
            points=points,
            max_distance=checked_distance(max_distance),
            normals=normal,
            max_angle=max_angle,
            mask=self._with_area,
        )

    def carrying_face(
        self,
        point: Any,
        *,
        max_distance: float = MAX_DISTANCE,
        normal: Optional[Any] = None,
        max_angle: Optional[float] = None,
    ) -> Optional[SurfacePoint]:
        """carry() for one point (3,); None off the map."""
        return self.geometry.spatial_index.closest(
            point=point,
            max_distance=checked_distance(max_distance),
            normal=normal,
            max_angle=max_angle,
            mask=self._with_area,
        )

    @cached_property
    def _with_area(self) -> Optional[np.ndarray]:
        without = self.geometry.faces_without_area
        return ~without if without.any() else None

    def values_at(self, points: Any, values: Any) -> np.ndarray:
        """A field of vertices at points of the surface (Pütz et al., eq. (4)).

        Of the corners of the face that have a weight (above 1e-6): +inf if one has +inf, else NaN
        if one has NaN, else linear. So what is told of an edge or vertex does not depend on the
        face.

        Args:
            points: SurfacePoints or SurfaceWalks.
            values: (V,) or (V, K).
        Returns:
            (N,) or (N, K) float64; NaN off the map.
        Raises:
            ValueError: another number of values.
        """
        return interpolate(self._per_vertex(values, "values"), self.faces, points)

    def directions_at(self, points: Any, vectors: Any) -> np.ndarray:
        """A field of directions at points of the surface (Pütz et al., eq. (3)).

        Corners without a direction (0, or not finite) are left out, as in the released mesh_map.

        Args:
            points: SurfacePoints or SurfaceWalks.
            vectors: (V, 3).
        Returns:
            (N, 3) float64 of length 1; zeros where there is none.
        Raises:
            ValueError: another shape.
        """
        field = self._per_vertex(vectors, "vectors")
        if field.shape[1:] != (3,):
            raise ValueError("vectors has to have the shape (V, 3), not %s" % (field.shape,))
        return interpolate_directions(field, self.faces, points)

    def cost_at(self, points: Any, *, costs: Optional[Any] = None, **near: Any) -> PointCosts:
        """The costs of the surface at points (N, 3).

        Args:
            points: (N, 3) meters.
            costs: see the class.
            near: max_distance, normal, max_angle: see the class.
        Raises:
            ValueError: as carry(), or another number of costs.
        """
        field = self._costs(costs)
        carried = self.carry(points, **near)
        return PointCosts(interpolate(field, self.faces, carried), carried)

    def path_cost(
        self, path: Any, *, costs: Optional[Any] = None, step: Optional[float] = None, **near: Any
    ) -> PathCost:
        """The cost along a path: straight pieces between points.

        Exact without a step: costs are linear in each face, and a path that leaves a face is
        followed over the surface to its next point, as SurfaceWalker.line() does. Where the surface
        does not lead there (a gap, another storey, off the map), it is sampled every 5 cm. There
        are at most 10,000 samples between two points of the path.

        Args:
            path: (N, 3) meters, N >= 1, such as the points of a plan.
            costs: see the class.
            step: meters, to sample all of it (along the straight pieces) that densely instead.
            near: max_distance, normal, max_angle: see the class.
        Raises:
            ValueError: as cost_at(); no points, points that are not finite, or a step that is not
                above 0.
        """
        points = points_array(path, "path")
        wrong = np.flatnonzero(~np.isfinite(points).all(1))
        if not len(points) or len(wrong):
            fault = "point %d is not finite" % wrong[0] if len(wrong) else "there is none"
            raise ValueError("a path needs at least one point, all finite: %s" % fault)
        if step is not None and not number(step, "step") > 0.0:
            raise ValueError("the step has to be above 0 m, not %g" % step)

        field = self._costs(costs)
        return path_cost(self.geometry, field, points, partial(self.carry, **near), step)

    def footprint_cost(
        self, footprint: Footprint, pose: Any, *, costs: Optional[Any] = None
    ) -> FootprintCost:
        """What is under a footprint. As footprint_costs(), for one pose (4, 4)."""
        return self.footprint_costs(footprint, np.asarray(pose)[None], costs=costs).cost(0)

    def footprint_costs(
        self,
        footprint: Footprint,
        poses: Any,
        *,
        costs: Optional[Any] = None,
        cancel: Optional[CancelFlag] = None,
    ) -> FootprintCosts:
        """What is under a footprint at each of N poses.

        A face counts if it touches the prism over the footprint, from `below` to `above`, in the
        frame of the robot.

        Args:
            footprint: of the robot.
            poses: (N, 4, 4), from the frame of the robot to that of the mesh, such as
                SurfaceWalk.matrix(); one that is not finite has no faces.
            costs: see the class.
            cancel: CancelFlag that ends the batch with Canceled.
        Raises:
            ValueError: another shape, or a pose that does more than turn and shift.
            Canceled: by `cancel`.
        """
        found = self.walker.kernel._costs_under(
            self.geometry.spatial_index.native,
            self._costs(costs),
            footprint.polygon,
            -footprint.below,
            footprint.above,
            pose_rows(poses),
            0,
            kernel_flag(cancel),
        )
        maxima, lethal, unknown, ground, counts = found
        return FootprintCosts(maxima, lethal.view(bool), unknown.view(bool), ground, counts)

    def vertices_under(
        self, footprint: Footprint, poses: Any, *, cancel: Optional[CancelFlag] = None
    ) -> FootprintVertices:
        """The vertices that say what the ground under a footprint is, at each of N poses.

        Each stands for those points of its faces to which it is the nearest corner, and counts if
        one of these points is in the prism over the footprint: so the one below a small footprint
        counts even if it lies beside it.

        Args:
            footprint, poses, cancel: as for footprint_costs().
        Raises:
            ValueError: another shape, or a pose that does more than turn and shift.
            Canceled: by `cancel`.
        """
        found = self.walker.kernel._vertices_under(
            self.geometry.spatial_index.native,
            footprint.polygon,
            -footprint.below,
            footprint.above,
            pose_rows(poses),
            0,
            kernel_flag(cancel),
        )
        return FootprintVertices(*found)

    def face_costs(self, how: str = MAX, costs: Optional[Any] = None) -> np.ndarray:
        """(F,) float32: costs of the faces, the largest or the mean of those of their corners.

        Args:
            how: "max" or "mean"; a face with a lethal corner is lethal, else one with an unknown
                corner unknown.
            costs: see the class.
        """
        return face_costs(self._costs(costs), self.faces, how)

    def _costs(self, costs: Optional[Any]) -> np.ndarray:
        if costs is None:
            if self._map is None:
                raise MeshMapError("a mesh has no costs", "give costs=, or ask MeshMap.queries")
            costs = self._map.costs
        array = _numbers(costs, "costs")
        with np.errstate(over="ignore"):  # what does not fit becomes lethal
            array = np.ascontiguousarray(array, np.float32)
        return one_each(array, "costs", len(self.vertices), "vertex")

    def _per_vertex(self, values: Any, name: str) -> np.ndarray:
        array = _numbers(values, name)
        if array.ndim not in (1, 2) or len(array) != len(self.vertices):
            raise ValueError(
                "%s has the shape %s: one row is needed for each of the %d vertices"
                % (name, array.shape, len(self.vertices))
            )
        return array


def _numbers(values: Any, name: str) -> np.ndarray:
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise ValueError("%s has to be numbers, not %s" % (name, array.dtype))
    return array


def _index(value: int, count: int, name: str) -> int:
    if not isinstance(value, (int, np.integer)) or not 0 <= value < count:
        raise IndexError("there is no %s %r: there are %d" % (name, value, count))
    return int(value)


def _without(indices: np.ndarray, own: int) -> np.ndarray:
    return indices[indices != own].astype(np.uint32)
