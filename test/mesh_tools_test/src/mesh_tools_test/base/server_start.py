"""How long a node that publishes a map takes from its start to the messages."""

import os
import subprocess
import threading
import time
from typing import Any, List, Sequence, Tuple

import rospy
from mesh_msgs import arrays
from osmesa_harness.master import private_master

PATIENCE = 120.0  # seconds

# topic, type, number of messages that have to arrive
Expected = Tuple[str, Any, int]


def executable(package: str, name: str) -> str:
    """Path of a node."""
    find = ["catkin_find", "--first-only", "--libexec", package, name]
    return subprocess.run(find, stdout=subprocess.PIPE, check=True).stdout.decode().strip()


def arrivals(command: Sequence[str], expected: Sequence[Expected]) -> List[float]:
    """Seconds until each of the messages has arrived, ascending.

    Subscribers wait before the node starts; the ROS master is a private one. Can be called once in
    a process. RuntimeError if the node ends or something does not arrive.
    """
    with private_master(os.environ) as environment:
        os.environ["ROS_MASTER_URI"] = environment["ROS_MASTER_URI"]
        rospy.init_node("start_benchmark", anonymous=True, disable_signals=True)
        times: List[float] = []
        complete = [threading.Semaphore(0) for _ in expected]

        def receive(number: int) -> None:
            times.append(time.monotonic())
            complete[number].release()

        subscribers = [
            rospy.Subscriber(
                topic,
                kind,
                lambda _, number=number: receive(number),
                queue_size=100,
                buff_size=1 << 24,
            )
            for number, (topic, kind, _) in enumerate(expected)
        ]
        start = time.monotonic()
        node = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
        try:
            for semaphore, (topic, _, count) in zip(complete, expected):
                for _ in range(count):
                    _wait(semaphore, topic, node, start + PATIENCE)
            return sorted(moment - start for moment in times)
        finally:
            for subscriber in subscribers:
                subscriber.unregister()
            node.terminate()
            node.wait(PATIENCE)
            rospy.signal_shutdown("measured")


def _wait(semaphore: Any, topic: str, node: Any, deadline: float) -> None:
    while not semaphore.acquire(timeout=1.0):
        if node.poll() is not None:
            raise RuntimeError("the node has ended with %d" % node.returncode)
        if time.monotonic() > deadline:
            raise RuntimeError("%s: not everything was published" % topic)


def start_to_messages(map_path: str, colors: bool, layers: int) -> Tuple[float, float]:
    """Of hdf5_map_server: seconds until the first, and until the last of geometry, colors and all
    layers has arrived.
    """
    times = arrivals(
        [executable("mesh_msgs_hdf5", "hdf5_map_server"), "_inputFile:=" + map_path],
        [
            ("mesh/geometry", arrays.MeshGeometryStamped, 1),
            ("mesh/vertex_colors", arrays.MeshVertexColorsStamped, int(colors)),
            ("mesh/vertex_costs", arrays.MeshVertexCostsStamped, layers),
        ],
    )
    return times[0], times[-1]
