"""How long hdf5_map_server takes from its start to the messages of a map."""

import os
import subprocess
import threading
import time
from typing import Tuple

import rospy
from mesh_msgs import arrays
from osmesa_harness.master import private_master

PATIENCE = 120.0  # seconds


def start_to_messages(map_path: str, colors: bool, layers: int) -> Tuple[float, float]:
    """Seconds until the first, and until the last of geometry, colors and all layers has arrived.

    Subscribers wait before the node starts; the ROS master is a private one. RuntimeError if the
    node ends or something does not arrive.
    """
    find = ["catkin_find", "--first-only", "--libexec", "mesh_msgs_hdf5", "hdf5_map_server"]
    found = subprocess.run(find, stdout=subprocess.PIPE, check=True).stdout.decode().strip()
    with private_master(os.environ) as environment:
        os.environ["ROS_MASTER_URI"] = environment["ROS_MASTER_URI"]
        rospy.init_node("map_file_benchmark", anonymous=True, disable_signals=True)
        arrived = threading.Semaphore(0)
        subscribers = [
            rospy.Subscriber(
                topic, kind, lambda _: arrived.release(), queue_size=100, buff_size=1 << 24
            )
            for topic, kind in (
                ("mesh/geometry", arrays.MeshGeometryStamped),
                ("mesh/vertex_colors", arrays.MeshVertexColorsStamped),
                ("mesh/vertex_costs", arrays.MeshVertexCostsStamped),
            )
        ]
        start = time.monotonic()
        node = subprocess.Popen(
            [found, "_inputFile:=" + map_path], env=environment, stdout=subprocess.DEVNULL
        )
        try:
            times = []
            for _ in range(1 + colors + layers):
                if not arrived.acquire(timeout=PATIENCE):
                    raise RuntimeError("hdf5_map_server did not publish everything")
                times.append(time.monotonic() - start)
            return times[0], times[-1]
        finally:
            for subscriber in subscribers:
                subscriber.unregister()
            node.terminate()
            node.wait(PATIENCE)
            rospy.signal_shutdown("measured")
