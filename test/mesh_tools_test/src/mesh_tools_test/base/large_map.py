"""A large map with what a real one has: noise of the scanner, normals, colors and cost layers."""

import numpy as np
from mesh_map.geometry.normals import face_normals, vertex_normals
from mesh_map.layers.threshold_layer import HeightDiffLayer
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs_hdf5.model.mesh import Mesh

NOISE = 0.003  # meters, of each coordinate
HIGH_STEP = 0.5  # meters of height difference that no robot climbs


def large_map(faces: int, seed: int = 0) -> Mesh:
    """The generated outdoor world of about that many faces, with five layers.

    height_diff, roughness and steepness are of full precision; inflation is +inf near steps and
    else 0; combined is their sum.
    """
    rng = np.random.default_rng(seed)
    world = outdoor_world(faces=faces, seed=seed)
    vertices = (world.vertices + rng.normal(0.0, NOISE, world.vertices.shape)).astype(np.float32)
    mesh_map = MeshMap(vertices, world.faces)
    topology = mesh_map.topology
    normals = vertex_normals(topology, *face_normals(vertices, world.faces))
    height_diff = HeightDiffLayer("height_diff").evaluate(mesh_map, {}).costs
    steepness = np.arccos(np.clip(normals[:, 2], -1.0, 1.0))
    inflation = np.where(height_diff > HIGH_STEP, np.float32(np.inf), np.float32(0.0))
    roughness = _roughness(topology.edges, normals)
    colors = world.colors + rng.normal(0.0, 6.0, world.colors.shape)
    return Mesh(
        vertices=vertices,
        faces=np.ascontiguousarray(world.faces, np.uint32),
        vertex_normals=normals,
        vertex_colors=np.clip(np.rint(colors), 0, 255).astype(np.uint8),
        vertex_costs={
            "height_diff": height_diff,
            "roughness": roughness,
            "steepness": steepness,
            "inflation": inflation,
            "combined": height_diff + roughness + steepness + inflation,
        },
        source={"generated": world.name},
    )


def write_ply(path: str, mesh: Mesh) -> None:
    """Write a binary PLY with normals and colors; meshio and Assimp read it."""
    names = [(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz")]
    names += [(name, "u1") for name in ("red", "green", "blue")]
    vertices = np.zeros(len(mesh.vertices), names)
    for columns, array in ((0, mesh.vertices), (3, mesh.vertex_normals), (6, mesh.vertex_colors)):
        for column in range(3):
            vertices[names[columns + column][0]] = array[:, column]
    faces = np.zeros(len(mesh.faces), [("size", "u1"), ("corners", "<i4", 3)])
    faces["size"], faces["corners"] = 3, mesh.faces
    kinds = {"<f4": "float", "u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", "element vertex %d" % len(vertices)]
    header += ["property %s %s" % (kinds[kind], name) for name, kind in names]
    header += ["element face %d" % len(faces), "property list uchar int vertex_indices"]
    with open(path, "wb") as file:
        file.write("\n".join(header + ["end_header\n"]).encode())
        vertices.tofile(file)
        faces.tofile(file)


def _roughness(edges: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Mean angle (radians) between the normal of a vertex and those of its neighbors."""
    cosine = np.einsum("ij,ij->i", normals[edges[:, 0]], normals[edges[:, 1]])
    angles = np.repeat(np.arccos(np.clip(cosine, -1.0, 1.0)), 2)
    count = np.bincount(edges.ravel(), minlength=len(normals))
    total = np.bincount(edges.ravel(), angles, len(normals))
    return (total / np.maximum(count, 1)).astype(np.float32)
