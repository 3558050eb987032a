"""Checks of received messages: one function for each message type, named as the type in snake_case.

Each returns a list of findings, empty for a valid message. A finding has a rule (a stable name),
says what is wrong, where first and how often, and what to do; str(finding) is the sentence to log:

    findings = validation.mesh_vertex_costs_stamped(message, vertex_count=len(vertices), uuid=uuid)
    if findings:
        rospy.logwarn("costs ignored: %s", findings[0])

Messages of the generated classes and those of mesh_msgs.arrays are both accepted; the latter take
a few milliseconds for a million vertices.

    vertex_count, face_count: sizes of the mesh at hand; None while they are not known.
    uuid: the UUID of the mesh at hand; None accepts any.

Floats are checked after narrowing to float32, which is what is drawn and planned with: 1e60 is
refused. Degenerate, duplicate and flipped faces are no findings, nor are normals of any length.
Of costs, NaN (unknown) and +inf (lethal) are legal.
"""

from mesh_msgs.checks.clusters import (  # noqa: F401
    mesh_face_cluster,
    mesh_face_cluster_stamped,
    mesh_label_colors,
    mesh_material,
    mesh_materials,
    mesh_materials_stamped,
    mesh_texture,
    mesh_vertex_costs_sparse,
    mesh_vertex_costs_sparse_stamped,
    mesh_vertex_tex_coords,
)
from mesh_msgs.checks.features import (  # noqa: F401
    feature,
    mesh_features,
    triangle_mesh,
    triangle_mesh_stamped,
    vector_field,
    vector_field_stamped,
)
from mesh_msgs.checks.findings import Finding  # noqa: F401
from mesh_msgs.checks.layers import layer_info, layer_info_array  # noqa: F401
from mesh_msgs.checks.localization import localization_state  # noqa: F401
from mesh_msgs.checks.store_results import store_result  # noqa: F401
from mesh_msgs.checks.geometry import (  # noqa: F401
    check_colors,
    check_costs,
    check_geometry,
    mesh_face_costs,
    mesh_face_costs_stamped,
    mesh_geometry,
    mesh_geometry_stamped,
    mesh_triangle_indices,
    mesh_vertex_colors,
    mesh_vertex_colors_stamped,
    mesh_vertex_costs,
    mesh_vertex_costs_stamped,
)
