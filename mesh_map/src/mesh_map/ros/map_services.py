"""The services of a map: its geometry and costs, and saving it."""

from typing import TYPE_CHECKING, Any, List

import numpy as np
import rospy
from mesh_msgs import array_services
from mesh_msgs.srv import (
    GetUUIDs,
    GetUUIDsResponse,
    GetVertexCostLayers,
    GetVertexCostLayersResponse,
)
from std_srvs.srv import Trigger, TriggerResponse

from mesh_map.base.errors import PLUGIN_FAILURES, MeshMapError, error_line
from mesh_map.io import map_messages
from mesh_map.map.mesh_map import MeshMap

if TYPE_CHECKING:
    from mesh_map.ros.mesh_map_server import MeshMapServer

# What stands for the only map, as for hdf5_map_server.
_THE_ONLY_ONE = ("", "mesh")


class MapServices:
    """Services below a namespace, of the types and meaning of hdf5_map_server's.

    A request that cannot be answered gets an error that says why, and what there is.
    """

    def __init__(self, server: "MeshMapServer") -> None:
        """Below the namespace of the server."""
        self._server = server
        prefix = server.namespace.rstrip("/") + "/"
        self._services: List[rospy.Service] = [
            rospy.Service(prefix + name, kind, handler)
            for name, kind, handler in (
                ("get_geometry", array_services.GetGeometry, self._geometry),
                ("get_uuids", GetUUIDs, self._uuids),
                ("get_vertex_colors", array_services.GetVertexColors, self._vertex_colors),
                ("get_vertex_cost_layers", GetVertexCostLayers, self._layers),
                ("get_vertex_costs", array_services.GetVertexCosts, self._costs),
                ("save_map", Trigger, self._save_map),
            )
        ]

    def shutdown(self) -> None:
        """Ends the services."""
        for service in self._services:
            service.shutdown()

    def _find(self, uuid: str) -> MeshMap:
        try:
            mesh_map = self._server.map
        except MeshMapError as error:
            raise rospy.ServiceException(str(error)) from error
        if uuid != mesh_map.uuid and uuid not in _THE_ONLY_ONE:
            raise rospy.ServiceException(
                "there is no map of uuid %r; known: %s" % (uuid[:80], mesh_map.uuid)
            )
        return mesh_map

    def _uuids(self, _request: Any) -> GetUUIDsResponse:
        return GetUUIDsResponse(uuids=[self._find("").uuid])

    def _geometry(self, request: Any) -> array_services.GetGeometryResponse:
        message = map_messages.geometry_message(self._find(request.uuid))
        return array_services.GetGeometryResponse(mesh_geometry_stamped=message)

    def _vertex_colors(self, request: Any) -> array_services.GetVertexColorsResponse:
        mesh_map, colors = self._find(request.uuid), self._server.colors
        if colors is None:
            colors = np.zeros((0, 3), np.uint8)
        message = map_messages.colors_message(mesh_map, colors)
        return array_services.GetVertexColorsResponse(mesh_vertex_colors_stamped=message)

    def _layers(self, request: Any) -> GetVertexCostLayersResponse:
        self._find(request.uuid)
        return GetVertexCostLayersResponse(layers=list(self._server.all_costs()))

    def _costs(self, request: Any) -> array_services.GetVertexCostsResponse:
        mesh_map, known = self._find(request.uuid), self._server.all_costs()
        costs = known.get(request.layer)
        if costs is None:
            raise rospy.ServiceException(
                "there is no layer %r; known: %s" % (request.layer[:80], ", ".join(known) or "none")
            )
        message = map_messages.costs_message(mesh_map, request.layer, costs)
        return array_services.GetVertexCostsResponse(mesh_vertex_costs_stamped=message)

    def _save_map(self, _request: Any) -> TriggerResponse:
        try:
            return TriggerResponse(success=True, message=self._server.save())
        except PLUGIN_FAILURES as error:
            rospy.logerr("save_map: %s", error_line(error))
            return TriggerResponse(success=False, message=error_line(error))
