"""A small map that has everything, for the tests of hdf5_map_server and what it is made of."""
import numpy as np
from mesh_msgs import arrays

from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh

LAYERS = ("height_diff", "roughness")


def everything(seed=1, vertices=12, faces=9):
    """A Mesh with one of everything; another seed is another geometry."""
    rng = np.random.default_rng(seed)
    costs = rng.random((len(LAYERS), vertices)).astype(np.float32)
    costs[0, :3] = np.inf, np.nan, 0
    face_materials = rng.integers(0, 3, faces).astype(np.uint32)
    face_materials[:3] = 0, 1, 0  # material 2 may have no face
    return Mesh(
        vertices=rng.normal(size=(vertices, 3)).astype(np.float32),
        faces=rng.integers(0, vertices, (faces, 3)).astype(np.uint32),
        vertex_normals=rng.normal(size=(vertices, 3)).astype(np.float32),
        vertex_colors=rng.integers(0, 256, (vertices, 3)).astype(np.uint8),
        vertex_costs=dict(zip(LAYERS, costs)),
        face_attributes={
            "slope": np.float32([np.inf, np.nan] + [0.5] * (faces - 2)),
            "face_normals": rng.normal(size=(faces, 3)).astype(np.float32),
        },
        texture_coordinates=rng.random((vertices, 2)).astype(np.float32),
        textures={
            0: rng.integers(0, 256, (2, 3, 3)).astype(np.uint8),
            3: rng.integers(0, 256, (5, 4, 4)).astype(np.uint8),
        },
        materials=Materials(
            rng.integers(0, 256, (3, 3)).astype(np.uint8), np.int32([3, -1, 0]), face_materials
        ),
        labels={
            "tree_1": Label(np.uint32([0, 2])),
            "tree_2": Label(np.uint32([1]), (10, 20, 30)),
            "bench_left": Label(np.uint32([3, 4, 5])),
        },
        features=Features(
            rng.normal(size=(4, 3)).astype(np.float32), rng.random((4, 8)).astype(np.float32)
        ),
        frame_id="floor",
    )


def layer_message(name, value=1.0, vertices=12):
    """A layer of one value, as it is sent to hdf5_map_server."""
    message = arrays.MeshVertexCostsStamped(type=name)
    message.mesh_vertex_costs.costs = np.full(vertices, value, np.float32)
    return message
