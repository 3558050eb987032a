#!/usr/bin/python3
"""Times of writing and reading mesh messages: lists of genpy objects, arrays, roscpp.

    serialization.py [--vertices 1000000] [--repeats 5] [--roscpp PROGRAM] [--json FILE]

Prints a table of medians and the ratios that matter, the way through a topic of a private master
from publish() to the callback among them; roscpp is measured where its program was built.
"""

import argparse
import io
import json
import os
import pathlib
import statistics
import subprocess
import sys
import threading
import time
from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA

import mesh_msgs.msg
from mesh_msgs import arrays, validation
from osmesa_harness.master import private_master

Table = Dict[str, float]  # name of a row: milliseconds


def milliseconds(action: Callable[[], Any], repeats: int) -> float:
    """Median time of an action."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return 1000.0 * statistics.median(times)


def grid(vertex_count: int) -> Tuple[np.ndarray, np.ndarray]:
    """A rough square of about that many vertices and twice as many faces."""
    side = max(2, round(vertex_count**0.5))
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    z = np.random.default_rng(0).random((side, side))
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(side - 1) + side * np.arange(side - 1)[:, None]).reshape(-1, 1)
    lower, upper = corner + [0, 1, side], corner + [1, side + 1, side]
    return vertices, np.concatenate([lower, upper]).astype(np.uint32)


def encoded(message: Any) -> bytes:
    """The bytes of a message, in a buffer of its own."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def rewrite(message: Any, buffer: io.BytesIO) -> None:
    """Writes into a buffer that has its size already, as rospy's publisher does."""
    buffer.seek(0)
    message.serialize(buffer)


def lists_of(vertices: np.ndarray, faces: np.ndarray) -> Any:
    """The message as genpy wants it: an object for each vertex and face."""
    message = mesh_msgs.msg.MeshGeometryStamped()
    geometry = message.mesh_geometry
    geometry.vertices = [Point(*row) for row in vertices.tolist()]
    geometry.vertex_normals = [Point(*row) for row in vertices.tolist()]
    geometry.faces = [mesh_msgs.msg.MeshTriangleIndices(row) for row in faces.tolist()]
    return message


def measure_lists(vertices: np.ndarray, faces: np.ndarray, repeats: int, table: Table) -> bytes:
    """Rows of MeshGeometryStamped in genpy's own form; returns its bytes."""
    stock = lists_of(vertices, faces)
    table["genpy: build lists"] = milliseconds(lambda: lists_of(vertices, faces), 1)
    wire = encoded(stock)
    table["genpy: serialize"] = milliseconds(lambda: encoded(stock), min(repeats, 3))
    table["genpy: deserialize"] = milliseconds(lambda: type(stock)().deserialize(wire), 1)
    return wire


def measure_geometry(vertices: np.ndarray, faces: np.ndarray, repeats: int, table: Table) -> Any:
    """Rows of MeshGeometryStamped; returns the array message."""
    wire = measure_lists(vertices, faces, repeats, table)
    reused = io.BytesIO(wire)
    single = arrays.MeshGeometryStamped()
    single.mesh_geometry = arrays.MeshGeometry(vertices, vertices, faces)
    wide = vertices.astype(np.float64)
    double = arrays.MeshGeometryStamped()
    double.mesh_geometry = arrays.MeshGeometry(wide, wide, faces)
    if encoded(single) != wire or encoded(double) != wire:
        sys.exit("error: bytes differ from genpy's")
    table["arrays: serialize float32, new buffer"] = milliseconds(lambda: encoded(single), repeats)
    table["arrays: serialize float64, new buffer"] = milliseconds(lambda: encoded(double), repeats)
    table["arrays: serialize float32, reused buffer"] = milliseconds(
        lambda: rewrite(single, reused), repeats
    )
    table["arrays: serialize float64, reused buffer"] = milliseconds(
        lambda: rewrite(double, reused), repeats
    )
    received = arrays.MeshGeometryStamped().deserialize(wire)
    table["arrays: deserialize to views"] = milliseconds(
        lambda: arrays.MeshGeometryStamped().deserialize(wire), 10 * repeats
    )
    table["arrays: deserialize to float32"] = milliseconds(
        lambda: [
            np.array(member, np.float32)
            for geometry in [arrays.MeshGeometryStamped().deserialize(wire).mesh_geometry]
            for member in (geometry.vertices, geometry.vertex_normals)
        ],
        repeats,
    )
    received.header.frame_id = "map"
    table["validation of the received message"] = milliseconds(
        lambda: validation.mesh_geometry_stamped(received), repeats
    )
    return double


def measure_attributes(vertex_count: int, repeats: int, table: Table) -> None:
    """Rows of costs and colors."""
    random = np.random.default_rng(1)
    rows = random.random((vertex_count, 4), np.float32)
    costs = arrays.MeshVertexCosts(costs=np.ascontiguousarray(rows[:, 0]))
    stock_costs = mesh_msgs.msg.MeshVertexCosts(rows[:, 0].tolist())
    colors = arrays.MeshVertexColors(vertex_colors=rows)
    stock_colors = mesh_msgs.msg.MeshVertexColors([ColorRGBA(*row) for row in rows.tolist()])
    for name, ours, stock in (("costs", costs, stock_costs), ("colors", colors, stock_colors)):
        wire = encoded(stock)
        if encoded(ours) != wire:
            sys.exit("error: bytes of %s differ from genpy's" % name)
        reused = io.BytesIO(wire)
        for side, message in (("genpy", stock), ("arrays", ours)):
            write, read = "%s: serialize %s" % (side, name), "%s: deserialize %s" % (side, name)
            table[write] = milliseconds(lambda m=message, b=reused: rewrite(m, b), repeats)
            table[read] = milliseconds(lambda c=type(message), w=wire: c().deserialize(w), repeats)


def measure_roscpp(program: Optional[str], faces: int, vertices: int, table: Table) -> None:
    """Rows of the C++ program beside this one, which prints "serialize MS" and "deserialize MS"."""
    if program is None:
        find = ["catkin_find", "--first-only", "--libexec", "mesh_tools_test"]
        found = subprocess.run(
            find + ["serialization_roscpp"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        program = found.stdout.decode().strip() or None
    if program is None or not pathlib.Path(program).is_file():
        return
    command = [program, str(vertices), str(faces)]
    printed = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.decode()
    for line in printed.splitlines():
        name, value = line.split()
        table["roscpp: " + name] = float(value)


def measure_topic(message: Any, repeats: int, table: Table) -> None:
    """From publish() to the callback, publisher and subscriber in this process over TCP."""
    with private_master(os.environ) as environment:
        os.environ["ROS_MASTER_URI"] = environment["ROS_MASTER_URI"]
        rospy.init_node("serialization_benchmark", anonymous=True, disable_signals=True)
        arrived = threading.Event()
        subscriber = rospy.Subscriber("~mesh", arrays.MeshGeometryStamped, lambda _: arrived.set())
        publisher = rospy.Publisher("~mesh", arrays.MeshGeometryStamped, queue_size=1)
        while not publisher.get_num_connections():
            time.sleep(0.05)

        def once() -> None:
            arrived.clear()
            publisher.publish(message)
            if not arrived.wait(60.0):
                sys.exit("error: a published mesh did not arrive within 60 s")

        once()
        table["arrays: publish to callback"] = milliseconds(once, repeats)
        subscriber.unregister()
        publisher.unregister()
        rospy.signal_shutdown("measured")


def ratios(table: Table) -> List[Tuple[str, float, str]]:
    """(what, ratio, target) of what was measured."""
    ours = table["arrays: serialize float64, new buffer"]
    genpy = table["genpy: serialize"]
    built = genpy + table["genpy: build lists"]
    views = table["arrays: deserialize to views"]
    found = [
        ("genpy serialize / arrays", genpy / ours, ">= 8"),
        ("genpy build + serialize / arrays", built / ours, ">= 100"),
        ("genpy deserialize / arrays", table["genpy: deserialize"] / views, ">= 100"),
    ]
    if "roscpp: serialize" in table:
        found.append(("arrays serialize / roscpp", ours / table["roscpp: serialize"], "<= 2"))
        found.append(("arrays deserialize / roscpp", views / table["roscpp: deserialize"], "<= 2"))
    return found


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--vertices", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--roscpp", metavar="PROGRAM", help="default: the one of mesh_tools_test")
    parser.add_argument("--json", metavar="FILE", help="also write the figures there")
    options = parser.parse_args()
    vertices, faces = grid(options.vertices)
    table: Table = {}
    message = measure_geometry(vertices, faces, options.repeats, table)
    measure_attributes(len(vertices), options.repeats, table)
    measure_roscpp(options.roscpp, len(faces), len(vertices), table)
    measure_topic(message, options.repeats, table)

    size = len(encoded(message)) / 1e6
    print(
        "MeshGeometryStamped, %d vertices with normals, %d faces, %.1f MB; medians"
        % (len(vertices), len(faces), size)
    )
    for name, value in table.items():
        print("%-42s %10.2f ms" % (name, value))
    for name, ratio, target in ratios(table):
        print("%-42s %10.1f    (target %s)" % (name, ratio, target))
    if "roscpp: serialize" not in table:
        print("not measured: roscpp (its program is not built)")
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps(table, indent=2) + "\n")


if __name__ == "__main__":
    main()
