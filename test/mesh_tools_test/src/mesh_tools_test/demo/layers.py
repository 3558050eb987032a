"""The layers of the demo, and the configuration with which the server computes the same."""
import numpy as np
import yaml

from mesh_msgs_hdf5.model.mesh import Label

# Ways through costly regions are longer for planners: up to 1 + EDGE_COST_FACTOR times.
EDGE_COST_FACTOR = 2.0
CLOUDS = "/cloud"  # of the robot's laser
MAX_EDGE_LENGTH = 0.25  # meters, of the generated world, whose edges are longer: the least radius
FLOWER_BED, BED_RADIUS, BED_AT = "flowerbed_1", 1.5, 0.14  # label, meters, share of the way


def layer(name, kind, **params):
    """An entry of the list of layers."""
    return {"name": name, "type": f"mesh_layers/{kind}Layer", "params": params}


# For a scanned map of anything; thresholds as users have them for outdoor maps.
FOR_FILES = [
    layer("height_diff", "HeightDiff", threshold=0.2, radius=0.3),
    layer("roughness", "Roughness", threshold=0.8, radius=0.3, factor=0.3),
    layer("steepness", "Steepness", threshold=0.7, factor=0.2),
    layer(
        "inflation",
        "Inflation",
        inscribed_radius=0.25,
        inflation_radius=1.0,
        inscribed_value=1.0,
        lethal_value=2.0,
        repulsive_field=False,
    ),
]

# For a reconstruction, which ends where nothing was seen: that is lethal, and what stands or hangs
# over the ground, whether or not scans join it to the ground.
FOR_SCANS = [
    *FOR_FILES[:-1],
    layer("border", "Border", border_cost=1.0, threshold=0.5, factor=0.0),
    layer("collision", "Collision", step_height=0.2, robot_height=1.0),
    dict(FOR_FILES[-1]),
]

# For the generated world: one of every kind.
FOR_WORLD = [
    layer("height_diff", "HeightDiff", threshold=0.25, radius=0.3, factor=0.5),
    layer("roughness", "Roughness", threshold=0.8, radius=0.3, factor=0.3),
    layer("steepness", "Steepness", threshold=0.7, factor=0.2),
    layer("ridge", "Ridge", threshold=1.0, radius=0.5, factor=0.0),
    layer("border", "Border", border_cost=1.0, threshold=0.5),
    layer("clearance", "Clearance", robot_height=0.7, height_inflation=0.3),
    layer("collision", "Collision", step_height=0.25, robot_height=0.7),
    layer("forbidden", "Label", lethal=["flowerbed"]),
    layer(
        "obstacle",
        "Obstacle",
        topic=CLOUDS,
        expected_update_rate=3.0,
        robot_height=1.0,
        min_obstacle_height=0.25,
        min_obstacle_dist=0.4,
        max_obstacle_dist=10.0,
    ),
    dict(FOR_FILES[-1]),
]


def flower_bed(mesh, start, goal):
    """A label that nobody may drive on: the faces in a circle on the straight way to the goal."""
    center = np.asarray(start) + BED_AT * (np.asarray(goal) - np.asarray(start))
    centers = mesh.vertices[mesh.faces].mean(axis=1)
    inside = np.linalg.norm(centers[:, :2] - center[:2], axis=1) < BED_RADIUS
    return Label(np.flatnonzero(inside).astype(np.uint32), (200, 60, 140))


def server_config(layers, max_edge_length):
    """YAML for the namespace of the map: the layers and what their costs mean to planners."""
    config = {
        "layers": [{"name": entry["name"], "type": entry["type"]} for entry in layers],
        "max_edge_length": max_edge_length,
        "edge_weight": "mean",
        "edge_cost_factor": EDGE_COST_FACTOR,
    }
    config.update((entry["name"], entry["params"]) for entry in layers)
    return yaml.safe_dump(config, sort_keys=False)
