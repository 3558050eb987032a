"""Node hdf5_map_server: publishes a mesh with its colors and cost layers, and offers services.
"""
import contextlib
import os
import signal
import sys
from typing import Iterator

import numpy as np
import rospy
from mesh_msgs import array_services, arrays
from mesh_msgs.init_node import init_node
from mesh_msgs.ros import LatchedTopics
from mesh_msgs.srv import (
    GetUUIDs,
    GetUUIDsResponse,
    GetVertexCostLayers,
    GetVertexCostLayersResponse,
)
from std_msgs.msg import Header

from mesh_msgs_hdf5.errors import MapFileError
from mesh_msgs_hdf5.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.mesh import Mesh

# clients of mesh_msgs_hdf5 1.x ask for "mesh"
_THE_ONLY_ONE = ("", "mesh")


class MapMessages:
    """The messages of one mesh, each made when it is asked for."""

    def __init__(self, mesh: Mesh, uuid: str, stamp: rospy.Time) -> None:
        self._mesh = mesh
        self.uuid = uuid
        self._header = Header(stamp=stamp, frame_id=mesh.frame_id)

    @property
    def layers(self):
        """Names of the layers, sorted."""
        return sorted(self._mesh.vertex_costs)

    def geometry(self) -> arrays.MeshGeometryStamped:
        normals = self._mesh.vertex_normals
        geometry = arrays.MeshGeometry(
            vertices=self._mesh.vertices,
            vertex_normals=np.zeros((0, 3), np.float32) if normals is None else normals,
            faces=self._mesh.faces,
        )
        return arrays.MeshGeometryStamped(
            header=self._header, uuid=self.uuid, mesh_geometry=geometry
        )

    def colors(self) -> arrays.MeshVertexColorsStamped:
        """Bytes as 0..1, alpha 1; of a mesh without colors, none."""
        rgb = self._mesh.vertex_colors
        rgba = np.ones((0 if rgb is None else len(rgb), 4), np.float32)
        if rgb is not None:
            rgba[:, :3] = rgb / np.float32(255)
        return arrays.MeshVertexColorsStamped(
            header=self._header,
            uuid=self.uuid,
            mesh_vertex_colors=arrays.MeshVertexColors(vertex_colors=rgba),
        )

    @property
    def has_colors(self) -> bool:
        return self._mesh.vertex_colors is not None

    def costs(self, layer: str) -> arrays.MeshVertexCostsStamped:
        """Raises KeyError for an unknown layer."""
        return arrays.MeshVertexCostsStamped(
            header=self._header,
            uuid=self.uuid,
            type=layer,
            mesh_vertex_costs=arrays.MeshVertexCosts(costs=self._mesh.vertex_costs[layer]),
        )


class MapServer:
    """Publishes the messages of a map, latched, and offers the services.

    Names are relative to the namespace.
    """

    def __init__(self, messages: MapMessages) -> None:
        self._map = messages
        self._topics = []
        self._publish("mesh/geometry", arrays.MeshGeometryStamped, messages.geometry())
        if messages.has_colors:
            self._publish("mesh/vertex_colors", arrays.MeshVertexColorsStamped, messages.colors())
        self._costs = LatchedTopics("mesh/vertex_costs", arrays.MeshVertexCostsStamped)
        for layer in messages.layers:
            self._costs.publish(layer, messages.costs(layer))
        self._services = [
            rospy.Service("get_uuids", GetUUIDs, self._get_uuids),
            rospy.Service("get_geometry", array_services.GetGeometry, self._get_geometry),
            rospy.Service("get_vertex_colors", array_services.GetVertexColors, self._get_colors),
            rospy.Service("get_vertex_costs", array_services.GetVertexCosts, self._get_costs),
            rospy.Service("get_vertex_cost_layers", GetVertexCostLayers, self._get_layers),
        ]

    def _publish(self, name, kind, message):
        publisher = rospy.Publisher(name, kind, queue_size=1, latch=True)
        publisher.publish(message)
        self._topics.append(publisher)

    def _check(self, uuid):
        if uuid != self._map.uuid and uuid not in _THE_ONLY_ONE:
            raise rospy.ServiceException(
                "there is no map of uuid %r; known: %s" % (uuid[:80], self._map.uuid)
            )

    def _get_uuids(self, _request):
        return GetUUIDsResponse(uuids=[self._map.uuid])

    def _get_geometry(self, request):
        self._check(request.uuid)
        return array_services.GetGeometryResponse(mesh_geometry_stamped=self._map.geometry())

    def _get_colors(self, request):
        self._check(request.uuid)
        return array_services.GetVertexColorsResponse(mesh_vertex_colors_stamped=self._map.colors())

    def _get_costs(self, request):
        self._check(request.uuid)
        if request.layer not in self._map.layers:
            raise rospy.ServiceException(
                "there is no layer %r; known: %s"
                % (request.layer[:80], ", ".join(self._map.layers) or "none")
            )
        costs = self._map.costs(request.layer)
        return array_services.GetVertexCostsResponse(mesh_vertex_costs_stamped=costs)

    def _get_layers(self, request):
        self._check(request.uuid)
        return GetVertexCostLayersResponse(layers=self._map.layers)


def load(path: str, part: str) -> MapMessages:
    """The messages of a map file or any file that can be imported, stamped now.

    One log line says what it is.
    """
    mesh, report = read_mesh(path, part)
    # a map file may hold the UUID that another program gave it
    uuid = MapFile(path, part).uuid if report.format == "HDF5" else mesh.uuid
    for note in report.notes:
        rospy.loginfo("%s: %s", path, note)
    rospy.loginfo(
        "serving %s: %d vertices, %d faces, layers: %s, frame %s, uuid %s",
        path,
        report.vertices,
        report.faces,
        ", ".join(sorted(mesh.vertex_costs)) or "none",
        mesh.frame_id,
        uuid,
    )
    return MapMessages(mesh, uuid, rospy.Time.now())


@contextlib.contextmanager
def ended_by_signals() -> Iterator[None]:
    """Within it SIGINT and SIGTERM end the work at once by a KeyboardInterrupt.

    rospy's own handlers only note the end, which long work does not look at.
    """
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, signal.default_int_handler) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, before):
            signal.signal(number, handler)


def main() -> int:
    """Run the node; returns the exit code."""
    try:
        init_node("hdf5_map_server")
        # absolute: a relative one counts from where the node runs, with roslaunch ~/.ros
        path = os.path.abspath(str(rospy.get_param("~inputFile", "/tmp/map.h5")))
        with ended_by_signals():
            messages = load(path, str(rospy.get_param("~mesh_part", "mesh")))
        MapServer(messages)
        rospy.spin()
    except MapFileError as error:
        sys.stderr.write("hdf5_map_server: error: %s\n" % error)
        return 1
    except KeyboardInterrupt:
        return 130  # as shells say it: ended by a signal before it served anything
    except rospy.ROSInterruptException:
        pass
    return 0
