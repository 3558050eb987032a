"""Paths that came from outside, checked and brought into the map's frame."""

import numpy as np

from mesh_navigation.base.pose import Pose, vector_text
from mesh_navigation.execution.path_execution import Tolerances

# Quaternions whose length differs more from 1 are no rotations but a fault.
UNIT_TOLERANCE = 0.01


def path_fault(poses: np.ndarray, tolerances: Tolerances) -> str:
    """What makes that a goal nobody can follow: one sentence, empty if nothing does.

    Args:
        poses: (N,7) position and quaternion x, y, z, w.
        tolerances: that the client asks for.
    """
    if not len(poses):
        return "the path is empty"
    fault = fault_of_poses(poses)
    if fault:
        return fault
    for name, value in tolerances._asdict().items():
        if not value >= 0.0:
            return f"the tolerance of {name} is {value}, not >= 0"
    return ""


def fault_of_poses(poses: np.ndarray) -> str:
    """What makes (N,7) poses none: one sentence, empty if nothing does."""
    bad = np.flatnonzero(~np.isfinite(poses).all(axis=1))
    if len(bad):
        where = vector_text(poses[bad[0]])
        return f"{len(bad)} of {len(poses)} poses are not finite, first pose {bad[0]}: {where}"
    norms = np.linalg.norm(poses[:, 3:], axis=1)
    bad = np.flatnonzero(np.abs(norms - 1.0) > UNIT_TOLERANCE)
    if len(bad):
        return (
            f"{len(bad)} of {len(poses)} poses have no unit quaternion, first pose {bad[0]}: "
            f"{vector_text(poses[bad[0], 3:])} (none at all: w = 1)"
        )
    return ""


def normalized_path(poses: np.ndarray) -> np.ndarray:
    """The same poses with quaternions of length 1."""
    norms = np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    return np.concatenate([poses[:, :3], poses[:, 3:] / norms], axis=1)


def transformed_path(poses: np.ndarray, frame: Pose) -> np.ndarray:
    """Poses given in a frame, in the frame in which that has the given pose."""
    x, y, z, w = frame.orientation / np.linalg.norm(frame.orientation)
    # The Hamilton product from the left as a matrix, and the rotation that belongs to it.
    product = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    axis = np.array([x, y, z])
    twice = 2.0 * np.cross(axis, poses[:, :3])
    positions = poses[:, :3] + w * twice + np.cross(axis, twice) + frame.position
    return np.concatenate([positions, poses[:, 3:] @ product.T], axis=1)
