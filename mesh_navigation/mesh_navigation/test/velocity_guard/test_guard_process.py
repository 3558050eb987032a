"""The process of the guard without a roscore: what it loads, and that it ends with the server."""

import os
import socket
import subprocess
import sys

from mesh_navigation.base.robot import Velocity
from mesh_navigation.velocity_guard.guard_records import DriveRecord, packed_settings

NODE = "mesh_navigation.velocity_guard.ros.velocity_guard_node"
RUN = f"from {NODE} import main; main()"


def test_it_loads_no_mesh_and_no_plugins():
    program = f"import sys, {NODE}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.PIPE)
    loaded = done.stdout.decode().split()
    assert NODE in loaded
    heavy = ("mesh_map", "tf2_ros", "mesh_navigation.plugins", "mesh_navigation.server")
    assert [name for name in loaded if name.startswith(heavy)] == []


def test_a_server_that_ends_at_once():
    """It ends before it has said anything, or while the guard waits for a roscore."""
    with socket.socket() as unused:  # Bound but not listening: nobody else can answer there.
        unused.bind(("localhost", 0))
        uri = f"http://localhost:{unused.getsockname()[1]}"
        for packets in ([], [packed_settings({"server_pid": -1})]):
            mine, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            with mine, its:
                for packet in packets:
                    mine.send(packet)
                mine.shutdown(socket.SHUT_WR)
                ended = subprocess.run(
                    [sys.executable, "-c", RUN, str(its.fileno())],
                    pass_fds=[its.fileno()],
                    env={**os.environ, "ROS_MASTER_URI": uri},
                    stderr=subprocess.PIPE,
                    timeout=60,
                )
            assert ended.returncode == 0, ended.stderr


def test_a_record_is_one_packet():
    for record in (
        DriveRecord(2**40, Velocity(0.1, -1e300, 0.3), 0.05, 1.7e9, 3.25e5),
        DriveRecord(0, ends=True),
    ):
        assert DriveRecord.unpacked(record.packed()) == record


def test_the_age_of_a_record():
    """By the clock by which it is younger: one that stands, or is read late, says nothing."""
    record = DriveRecord(1, period=0.05, due=100.05, sent=7.0)
    for time, wall, age in (
        (101.0, 8.0, 1.0),
        (101.0, 7.25, 0.25),  # the time of ROS runs fast
        (100.25, 9.0, 0.25),  # it waits
        (0.0, 9.0, 0.0),  # it was set back
        (101.0, 6.0, 0.0),
    ):
        assert abs(record.age(time, wall) - age) < 1e-9
