"""What brings layers data, as the server starts it; without a roscore."""

import contextlib
import threading

import numpy as np
import pytest
from mesh_map import MeshMap
from mesh_map.ros.layer_adapters import LayerAdapters
from mesh_map.ros.ros_adapter import RosAdapter
from toy_layers import TYPES, DataLayer, NeighborLayer, entry, grid_map
from toy_layers import toys  # noqa: F401

WAIT = 60.0  # seconds; far more than anything takes
CONFIG = [
    entry("ground", "data"),
    entry("obstacles", "seen"),
    entry("near", "blocking", ["ground", "obstacles"]),
    entry("all", "max"),
]


class SeenLayer(DataLayer):
    ROS_ADAPTER = __name__ + ".Sensor"


class Sensor(RosAdapter):
    made = []

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.made.append(self)

    def shutdown(self):
        self.made.remove(self)


class BlockingReader(NeighborLayer):
    """Waits in each evaluation until `go_on` is set."""

    begun, go_on = threading.Semaphore(0), threading.Event()

    def update(self, *arguments):
        self.begun.release()
        assert self.go_on.wait(WAIT)
        return super().update(*arguments)


@pytest.fixture
def sensor(toys, monkeypatch):  # noqa: F811
    """What the server has started for the layer "obstacles"."""
    monkeypatch.setitem(TYPES, "seen", SeenLayer)
    monkeypatch.setitem(TYPES, "blocking", BlockingReader)
    monkeypatch.setattr(BlockingReader, "begun", threading.Semaphore(0))
    monkeypatch.setattr(BlockingReader, "go_on", threading.Event())
    mesh_map = grid_map()
    mesh_map.layer_timeout = WAIT
    mesh_map.compute_layers(CONFIG)
    with contextlib.ExitStack() as in_use:
        LayerAdapters("/map", mesh_map, in_use).start()
        yield Sensor.made[0]
        BlockingReader.go_on.set()
    assert not Sensor.made


def see(sensor, toys, *vertices):  # noqa: F811
    """Obstacles there, as a cloud has them; in the thread of the sensor."""
    toys["obstacles"] = np.zeros(64, np.float32)
    toys["obstacles"][list(vertices)] = np.inf
    thread = threading.Thread(target=sensor.refresh, daemon=True)
    thread.start()
    thread.join(WAIT / 2)
    assert not thread.is_alive(), "the sensor waits for layers that read it"


def test_clouds_do_not_wait_for_who_reads_them(sensor, toys):  # noqa: F811
    mesh_map, told = sensor.mesh_map, []
    mesh_map.add_listener(told.append)
    for vertices in ((20,), (20, 21), (40,)):
        see(sensor, toys, *vertices)
        assert np.flatnonzero(np.isinf(mesh_map.planning_costs().costs)).tolist() == [*vertices]
        assert mesh_map.stale_layers == ("near", "all") and mesh_map.fault == ""
        assert told[-1][-1].name == "Combined Costs" and vertices[-1] in told[-1][-1].vertices
        assert [one.name for one in threading.enumerate()].count("layers") == 1
    assert BlockingReader.begun.acquire(timeout=WAIT)
    BlockingReader.go_on.set()
    mesh_map.catch_up()
    fresh = MeshMap.of(mesh_map.geometry)
    fresh.compute_layers(CONFIG)
    assert mesh_map.stale_layers == () and mesh_map.fault == ""
    for name, layer in fresh.layers.items():
        assert np.array_equal(mesh_map.layers[name].result.costs, layer.result.costs)
    assert np.array_equal(mesh_map.costs, fresh.costs)
