"""Services whose responses carry the array messages of mesh_msgs.arrays.

Each class stands for the generated one of the same name, with the same type, md5 sum and requests,
in `rospy.Service` as well as `rospy.ServiceProxy`; the other side may use the generated one.

    def answer(request):
        return array_services.GetGeometryResponse(mesh_geometry_stamped=message)

    rospy.Service("get_geometry", array_services.GetGeometry, answer)
"""

from typing import Any

import mesh_msgs.srv

from mesh_msgs import arrays  # noqa: F401  (responses are made of these)
from mesh_msgs.wire.array_message import ArrayMessage


def _with_arrays(service: Any) -> Any:
    """The generated service, with the array class of its response."""
    stock = service._response_class
    told = {"__module__": __name__, "__doc__": ", ".join(stock.__slots__) + ", with arrays."}
    response = type(stock.__name__, (ArrayMessage, stock), dict(told, __slots__=()))
    told = {"__module__": __name__, "__doc__": "mesh_msgs/%s with arrays." % service.__name__}
    return type(service.__name__, (service,), dict(told, _response_class=response))


GetGeometry = _with_arrays(mesh_msgs.srv.GetGeometry)
GetGeometryResponse = GetGeometry._response_class
GetVertexColors = _with_arrays(mesh_msgs.srv.GetVertexColors)
GetVertexColorsResponse = GetVertexColors._response_class
GetVertexCosts = _with_arrays(mesh_msgs.srv.GetVertexCosts)
GetVertexCostsResponse = GetVertexCosts._response_class
GetMaterials = _with_arrays(mesh_msgs.srv.GetMaterials)
GetMaterialsResponse = GetMaterials._response_class
GetLabeledClusters = _with_arrays(mesh_msgs.srv.GetLabeledClusters)
GetLabeledClustersResponse = GetLabeledClusters._response_class
GetLabeledClusterGroup = _with_arrays(mesh_msgs.srv.GetLabeledClusterGroup)
GetLabeledClusterGroupResponse = GetLabeledClusterGroup._response_class
GetDerivedMesh = _with_arrays(mesh_msgs.srv.GetDerivedMesh)
GetDerivedMeshResponse = GetDerivedMesh._response_class
DeleteLabel = _with_arrays(mesh_msgs.srv.DeleteLabel)
DeleteLabelResponse = DeleteLabel._response_class
