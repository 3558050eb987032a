"""Messages of meshes as NumPy arrays, without a Python object for each vertex.

Each class here is a subclass of the generated class of the same name, with the same `_type`,
`_md5sum`, `_full_text` and bytes, so it goes wherever that one goes: `rospy.Publisher`,
`rospy.Subscriber`, rosbag. It may be published on a topic of the generated class and received from
one.

    message = arrays.MeshGeometry(vertices=vertices, faces=faces)   # (V, 3) floats, (F, 3) integers
    rospy.Subscriber("mesh", arrays.MeshGeometryStamped, lambda m: plan(m.mesh_geometry.vertices))

Members are checked when they are assigned (ArrayError, a ValueError). Floats may be float32 or
float64. Integers of any type are accepted for indices, but a negative or too large one is refused.
Lists of numbers, rows or message objects become arrays. An array that needs no conversion is kept,
not copied: what its owner changes later changes the message.

Arrays of a received message are read-only views of the received bytes and need not be aligned: copy
them before changing them, and pass them through `np.require(array, requirements="CA")` before
handing them to native code.
"""

import mesh_msgs.msg

from mesh_msgs.wire.array_message import ArrayMessage
from mesh_msgs.wire.fields import ScalarListField
from mesh_msgs.wire.framing import ArrayError  # noqa: F401  (what users catch)


class MeshGeometry(ArrayMessage, mesh_msgs.msg.MeshGeometry):
    """vertices (V, 3) [m], vertex_normals (V, 3) of length 1 or (0, 3), faces (F, 3) uint32."""

    __slots__ = ()


class MeshGeometryStamped(ArrayMessage, mesh_msgs.msg.MeshGeometryStamped):
    """A geometry with frame, time and identity."""

    __slots__ = ()


class MeshVertexColors(ArrayMessage, mesh_msgs.msg.MeshVertexColors):
    """vertex_colors (V, 4) float32: red, green, blue, alpha, 0 to 1."""

    __slots__ = ()


class MeshVertexColorsStamped(ArrayMessage, mesh_msgs.msg.MeshVertexColorsStamped):
    """Colors of the vertices of the geometry `uuid`."""

    __slots__ = ()


class MeshVertexCosts(ArrayMessage, mesh_msgs.msg.MeshVertexCosts):
    """costs (V,) float32: finite >= 0 is a cost, +inf lethal, NaN unknown."""

    __slots__ = ()


class MeshVertexCostsStamped(ArrayMessage, mesh_msgs.msg.MeshVertexCostsStamped):
    """The cost layer `type` of the geometry `uuid`."""

    __slots__ = ()


class MeshFaceCosts(ArrayMessage, mesh_msgs.msg.MeshFaceCosts):
    """costs (F,) float32: finite >= 0 is a cost, +inf lethal, NaN unknown."""

    __slots__ = ()


class MeshFaceCostsStamped(ArrayMessage, mesh_msgs.msg.MeshFaceCostsStamped):
    """The cost layer `type` on the faces of the geometry `uuid`."""

    __slots__ = ()


class MeshVertexCostsSparse(ArrayMessage, mesh_msgs.msg.MeshVertexCostsSparse):
    """vertices (N,) uint32 and their costs (N,) float32; all other vertices have default_value."""

    __slots__ = ()


class MeshVertexCostsSparseStamped(ArrayMessage, mesh_msgs.msg.MeshVertexCostsSparseStamped):
    """Changed or sparse costs of the layer `type` of the geometry `uuid`."""

    __slots__ = ()


class MeshFaceCluster(ArrayMessage, mesh_msgs.msg.MeshFaceCluster):
    """face_indices (N,) uint32 of the faces that bear `label`."""

    __slots__ = ()


class MeshFaceClusterStamped(ArrayMessage, mesh_msgs.msg.MeshFaceClusterStamped):
    """A cluster of the geometry `uuid`; `override` replaces one of this label, else extends it."""

    __slots__ = ()


class MeshMaterials(ArrayMessage, mesh_msgs.msg.MeshMaterials):
    """vertex_tex_coords (V, 2) float32 or (0, 2); all other members are lists.

    Received clusters are MeshFaceCluster of this module; assigned ones may be of either class.
    """

    __slots__ = ()
    OTHER_FIELDS = {"cluster_materials": ScalarListField}


class MeshMaterialsStamped(ArrayMessage, mesh_msgs.msg.MeshMaterialsStamped):
    """Materials of the geometry `uuid`."""

    __slots__ = ()


class VectorField(ArrayMessage, mesh_msgs.msg.VectorField):
    """positions (N, 3) [m] and the vectors (N, 3) that start there."""

    __slots__ = ()


class VectorFieldStamped(ArrayMessage, mesh_msgs.msg.VectorFieldStamped):
    """A vector field with frame and time."""

    __slots__ = ()
