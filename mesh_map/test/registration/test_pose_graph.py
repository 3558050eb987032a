"""Poses in a loop: the least squares, and what does not fit."""

import numpy as np
from scipy.optimize import least_squares

from mesh_map.registration.pose_graph import PoseEdge, optimized
from mesh_map.registration.rigid import inverse, motion, numbers_of

STRONG, WEAK = 1e4 * np.eye(6), np.diag([100.0] * 3 + [2500.0] * 3)


def circle(count=12):
    step = motion([3.0, 0, 0.1, 0, 0.01, 2 * np.pi / count])
    poses = [np.eye(4)]
    for _ in range(count - 1):
        poses.append(poses[-1] @ step)
    return poses


def drifting(truth, seed=0):
    """Edges from each pose to the next that are off, and the poses that they lead to."""
    random = np.random.default_rng(seed)
    edges, poses = [], [truth[0]]
    for k in range(len(truth) - 1):
        wrong = motion(np.r_[0.03, 0.01, 0, 0, 0, 0.01] + 0.003 * random.standard_normal(6))
        measured = inverse(truth[k]) @ truth[k + 1] @ wrong
        edges.append(PoseEdge(k, k + 1, measured, WEAK))
        poses.append(poses[-1] @ measured)
    return poses, edges


def off(poses, truth):
    return max(np.linalg.norm(a[:3, 3] - b[:3, 3]) for a, b in zip(poses, truth))


def test_a_loop_is_closed_by_the_least_squares():
    truth = circle()
    poses, edges = drifting(truth)
    edges.append(PoseEdge(len(truth) - 1, 0, inverse(truth[-1]) @ truth[0], STRONG))
    found = optimized(poses, edges)
    assert off(poses, truth) > 3 * off(found, truth)
    np.testing.assert_array_equal(found[0], poses[0])

    roots = [np.linalg.cholesky(edge.information).T for edge in edges]

    def errors(numbers):
        tried = found[:1] + [
            pose @ motion(part) for pose, part in zip(found[1:], numbers.reshape(-1, 6))
        ]
        return np.concatenate(
            [
                root
                @ numbers_of(
                    inverse(edge.measured) @ inverse(tried[edge.first]) @ tried[edge.second]
                )
                for edge, root in zip(edges, roots)
            ]
        )

    start = np.zeros(6 * (len(truth) - 1))
    best = least_squares(errors, start, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    assert np.square(errors(start)).sum() <= 2 * best.cost * (1 + 1e-6)
    assert np.abs(best.x).max() < 1e-4


def test_a_false_loop_does_not_bend_the_others():
    truth = circle()
    poses, edges = drifting(truth)
    loops = [
        PoseEdge(0, 11, inverse(truth[0]) @ truth[11], STRONG, 3.0),
        PoseEdge(1, 10, inverse(truth[1]) @ truth[10], STRONG, 3.0),
    ]
    wrong = inverse(truth[2]) @ truth[8] @ motion([2.0, 0, 0, 0, 0, 1.0])
    false = PoseEdge(2, 8, wrong, STRONG, 3.0)
    without = optimized(poses, edges + loops)
    with_it = optimized(poses, edges + loops + [false])
    believed = optimized(poses, edges + loops + [false._replace(doubt=np.inf)])
    assert 10 * off(with_it, without) < off(believed, without)


def test_nothing_to_do():
    assert optimized([], []) == []
    one = [np.eye(4)]
    assert np.array_equal(optimized(one, [])[0], one[0])
    truth = circle()
    steps = [inverse(a) @ b for a, b in zip(truth, truth[1:])]
    edges = [PoseEdge(k, k + 1, step, WEAK) for k, step in enumerate(steps)]
    assert off(optimized(truth, edges), truth) < 1e-9
