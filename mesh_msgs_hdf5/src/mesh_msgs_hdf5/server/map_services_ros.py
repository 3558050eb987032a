"""The services of hdf5_map_server."""
from typing import Any, Callable, List

import rospy
from mesh_msgs import array_services
from mesh_msgs.srv import (
    GetTexture,
    GetTextureResponse,
    GetUUID,
    GetUUIDResponse,
    GetUUIDs,
    GetUUIDsResponse,
    GetVertexCostLayers,
    GetVertexCostLayersResponse,
)

from mesh_msgs_hdf5.ros.label_services_ros import answering
from mesh_msgs_hdf5.ros.map_messages import FACES, NORMALS, VERTICES
from mesh_msgs_hdf5.server.map_registry import MapRegistry, UnknownMap
from mesh_msgs_hdf5.server.received import Refused
from mesh_msgs_hdf5.server.served_map import ServedMap
from mesh_msgs_hdf5.server.typed_services_ros import ServiceOfTwoTypes

# names that the layers of the two services of release 1.0 have in files
_ROUGHNESS = ("roughness",)
_HEIGHT_DIFFERENCE = ("height_diff", "height_difference")


class MapServerServices:
    """Each answers for the map whose uuid is asked for, or with an error that names the known ones.

    Handlers run in threads of their own; the maps see to it that one at a time reads a file.
    """

    def __init__(self, maps: MapRegistry) -> None:
        self._maps = maps
        self._services: List[rospy.Service] = [
            rospy.Service("get_uuids", GetUUIDs, self._get_uuids),
            # release 1.0 has GetUUID; the RViz plugin of 1.1 calls it as GetUUIDs
            ServiceOfTwoTypes("get_uuid", (GetUUID, self._get_uuid), (GetUUIDs, self._get_uuids)),
        ]
        for name, kind, handler in (
            ("get_geometry", array_services.GetGeometry, _geometry(VERTICES, FACES, NORMALS)),
            ("get_geometry_vertices", array_services.GetGeometry, _geometry(VERTICES)),
            ("get_geometry_faces", array_services.GetGeometry, _geometry(FACES)),
            ("get_geometry_vertexnormals", array_services.GetGeometry, _geometry(NORMALS)),
            ("get_vertex_colors", array_services.GetVertexColors, _get_colors),
            ("get_vertex_cost_layers", GetVertexCostLayers, _get_layers),
            ("get_vertex_costs", array_services.GetVertexCosts, _get_costs),
            ("get_roughness", array_services.GetVertexCosts, _layer(_ROUGHNESS)),
            ("get_height_difference", array_services.GetVertexCosts, _layer(_HEIGHT_DIFFERENCE)),
            ("get_materials", array_services.GetMaterials, _get_materials),
            ("get_texture", GetTexture, _get_texture),
        ):
            self._services.append(rospy.Service(name, kind, self._answering(handler)))

    def _answering(self, handler: Callable[[ServedMap, Any], Any]) -> Callable[[Any], Any]:
        def answer(request: Any) -> Any:
            return handler(self._maps.find(request.uuid), request)

        return answering(answer, UnknownMap, Refused)

    def _get_uuids(self, _request: Any) -> GetUUIDsResponse:
        return GetUUIDsResponse(uuids=self._maps.uuids())

    def _get_uuid(self, _request: Any) -> GetUUIDResponse:
        return GetUUIDResponse(uuid=self._maps.uuids()[0])


def _geometry(*parts):
    def handler(served, _request):
        message = served.messages.geometry(parts)
        return array_services.GetGeometryResponse(mesh_geometry_stamped=message)

    return handler


def _get_colors(served, _request):
    message = served.messages.vertex_colors()
    return array_services.GetVertexColorsResponse(mesh_vertex_colors_stamped=message)


def _get_layers(served, _request):
    return GetVertexCostLayersResponse(layers=served.messages.vertex_cost_names())


def _get_costs(served, request):
    return _costs(served, (request.layer,))


def _layer(names):
    """A service that is for one layer; the layer of the request does not matter."""
    return lambda served, _request: _costs(served, names)


def _costs(served, names):
    known = served.messages.vertex_cost_names()
    for name in names:
        if name in known:
            message = served.messages.vertex_costs(name)
            return array_services.GetVertexCostsResponse(mesh_vertex_costs_stamped=message)
    raise rospy.ServiceException(
        "there is no layer %r; known: %s" % (names[0][:80], ", ".join(known) or "none")
    )


def _get_materials(served, _request):
    message = served.messages.materials()
    return array_services.GetMaterialsResponse(mesh_materials_stamped=message)


def _get_texture(served, request):
    known = served.overlay.texture_indices()
    if request.texture_index not in known:
        raise rospy.ServiceException(
            "there is no texture %d; known: %s"
            % (request.texture_index, ", ".join(map(str, known)) or "none")
        )
    return GetTextureResponse(texture=served.messages.texture(request.texture_index))
