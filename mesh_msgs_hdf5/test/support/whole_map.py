"""A map file with everything that one can hold, also scans, another part and a label journal."""
import numpy as np

from mesh_msgs_hdf5.formats.exporter import write_mesh
from mesh_msgs_hdf5.labels.label_store import LabelStore
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.scans import ScanFile
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh


def write_whole_map(path):
    """Writes it: a hilly floor near an origin, with a seam of its texture."""
    rng = np.random.default_rng(5)
    x, y = (values.ravel() for values in np.meshgrid(np.arange(7), np.arange(5)))
    corner = (np.arange(4)[:, None] * 7 + np.arange(6)).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + 8], 1),
            np.stack([corner, corner + 8, corner + 7], 1),
        ]
    )
    seam = np.array([10, 17, 24])  # the faces on the right of it have copies of these
    of_points = np.concatenate([np.arange(35), seam])
    right = (x[faces] >= 3).all(1)
    faces = np.where(np.isin(faces, seam) & right[:, None], 35 + (faces - 10) // 7, faces)
    vertices = np.stack([x / 3, y / 3, rng.random(35)], 1).astype(np.float32)[of_points]
    normals = rng.normal(size=(35, 3))[of_points]
    costs = rng.random(35).astype(np.float32)
    costs[:2] = np.inf, np.nan
    mesh = Mesh(
        vertices,
        faces.astype(np.uint32),
        vertex_normals=(normals / np.linalg.norm(normals, axis=1)[:, None]).astype(np.float32),
        vertex_colors=rng.integers(0, 256, (35, 3)).astype(np.uint8)[of_points],
        vertex_costs={"height_diff": costs[of_points]},
        layer_parameters={"height_diff": {"radius": 0.3}},
        vertex_attributes={
            "scan": rng.integers(0, 2**60, 35)[of_points],
            "feature": rng.random((35, 3))[of_points],
        },
        vertex_parameters={"scan": {"of": "hall.bag"}},
        face_attributes={
            "cost": rng.random(48).astype(np.float32),
            "class_id": rng.integers(0, 9, 48).astype(np.uint8),
        },
        face_parameters={"cost": {"radius": 0.5}},
        texture_coordinates=np.concatenate(
            [np.stack([x / 6, y / 4], 1), np.stack([x / 6 - 0.4, y / 4], 1)[seam]]
        ).astype(np.float32),
        seam_originals=seam.astype(np.uint32),
        textures={0: rng.integers(0, 256, (5, 7, 3)).astype(np.uint8)},
        materials=Materials(
            np.uint8([[200, 100, 50], [1, 2, 3]]),
            np.int32([0, -1]),
            np.repeat([0, 1], 24).astype(np.uint32),
        ),
        labels={"tree_1": Label(np.uint32([3, 4, 5]), (0, 128, 255)), "bench_1": Label([9])},
        features=Features(
            rng.random((3, 3)).astype(np.float32), rng.random((3, 8)).astype(np.float32)
        ),
        frame_id="floor_2",
        origin=(430000.5, 5790000.0, 12.0),
        crs="EPSG:25832",
        source={"file": "scans.bag"},
    )
    MapFile.write(path, mesh)
    MapFile.write_part(path, Mesh(vertices + 9, faces), "floor_3")
    with LabelStore(path) as store:
        store.set("wall_1", [1, 2])
    cloud = path.with_name("cloud.ply")
    write_mesh(cloud, mesh)
    ScanFile(path).add([str(cloud)])
