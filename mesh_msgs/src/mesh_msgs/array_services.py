"""Services whose responses carry the array messages of mesh_msgs.arrays.

Each class stands for the generated one of the same name, with the same type, md5 sum and requests,
in `rospy.Service` as well as `rospy.ServiceProxy`; the other side may use the generated one.

    def answer(request):
        return array_services.GetGeometryResponse(mesh_geometry_stamped=message)

    rospy.Service("get_geometry", array_services.GetGeometry, answer)
"""

import mesh_msgs.srv

from mesh_msgs import arrays
from mesh_msgs.wire.array_message import ArrayMessage
from mesh_msgs.wire.fields import MessageField, MessageListField

__all__ = [
    "DeleteLabel",
    "DeleteLabelResponse",
    "GetGeometry",
    "GetGeometryResponse",
    "GetLabeledClusterGroup",
    "GetLabeledClusterGroupResponse",
    "GetLabeledClusters",
    "GetLabeledClustersResponse",
    "GetMaterials",
    "GetMaterialsResponse",
    "GetVertexColors",
    "GetVertexColorsResponse",
    "GetVertexCosts",
    "GetVertexCostsResponse",
]

_EMPTY_CLUSTER = 8  # bytes: two lengths


class GetGeometryResponse(ArrayMessage, mesh_msgs.srv.GetGeometryResponse):
    """mesh_geometry_stamped."""

    __slots__ = ()
    FIELDS = (MessageField("mesh_geometry_stamped", arrays.MeshGeometryStamped),)


class GetVertexColorsResponse(ArrayMessage, mesh_msgs.srv.GetVertexColorsResponse):
    """mesh_vertex_colors_stamped."""

    __slots__ = ()
    FIELDS = (MessageField("mesh_vertex_colors_stamped", arrays.MeshVertexColorsStamped),)


class GetVertexCostsResponse(ArrayMessage, mesh_msgs.srv.GetVertexCostsResponse):
    """mesh_vertex_costs_stamped."""

    __slots__ = ()
    FIELDS = (MessageField("mesh_vertex_costs_stamped", arrays.MeshVertexCostsStamped),)


class GetMaterialsResponse(ArrayMessage, mesh_msgs.srv.GetMaterialsResponse):
    """mesh_materials_stamped."""

    __slots__ = ()
    FIELDS = (MessageField("mesh_materials_stamped", arrays.MeshMaterialsStamped),)


class GetLabeledClustersResponse(ArrayMessage, mesh_msgs.srv.GetLabeledClustersResponse):
    """clusters, a list of MeshFaceCluster."""

    __slots__ = ()
    FIELDS = (MessageListField("clusters", arrays.MeshFaceCluster, _EMPTY_CLUSTER),)


class GetLabeledClusterGroupResponse(ArrayMessage, mesh_msgs.srv.GetLabeledClusterGroupResponse):
    """clusters, a list of MeshFaceCluster."""

    __slots__ = ()
    FIELDS = (MessageListField("clusters", arrays.MeshFaceCluster, _EMPTY_CLUSTER),)


class DeleteLabelResponse(ArrayMessage, mesh_msgs.srv.DeleteLabelResponse):
    """cluster, the one that was deleted."""

    __slots__ = ()
    FIELDS = (MessageField("cluster", arrays.MeshFaceCluster),)


class GetGeometry(mesh_msgs.srv.GetGeometry):
    """mesh_msgs/GetGeometry with arrays."""

    _response_class = GetGeometryResponse


class GetVertexColors(mesh_msgs.srv.GetVertexColors):
    """mesh_msgs/GetVertexColors with arrays."""

    _response_class = GetVertexColorsResponse


class GetVertexCosts(mesh_msgs.srv.GetVertexCosts):
    """mesh_msgs/GetVertexCosts with arrays."""

    _response_class = GetVertexCostsResponse


class GetMaterials(mesh_msgs.srv.GetMaterials):
    """mesh_msgs/GetMaterials with arrays."""

    _response_class = GetMaterialsResponse


class GetLabeledClusters(mesh_msgs.srv.GetLabeledClusters):
    """mesh_msgs/GetLabeledClusters with arrays."""

    _response_class = GetLabeledClustersResponse


class GetLabeledClusterGroup(mesh_msgs.srv.GetLabeledClusterGroup):
    """mesh_msgs/GetLabeledClusterGroup with arrays."""

    _response_class = GetLabeledClusterGroupResponse


class DeleteLabel(mesh_msgs.srv.DeleteLabel):
    """mesh_msgs/DeleteLabel with arrays."""

    _response_class = DeleteLabelResponse
