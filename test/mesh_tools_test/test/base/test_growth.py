"""How times grow, in a table and in a plot."""
import numpy as np
from PIL import Image

from mesh_tools_test.base.growth import Growth

GROWTH = Growth("faces", [1_000, 10_000], [{"a": 1.0, "b": 0.0}, {"a": 20.0, "b": 0.5}])


def test_table():
    lines = [line.split() for line in GROWTH.table().splitlines()]
    assert lines[0] == ["ms", "1,000", "10,000", "growth"]
    assert lines[1] == ["a", "1", "20", "20.0", "x"]
    assert lines[2][:3] == ["b", "0", "0.5"]
    assert lines[3] == ["faces", "10.0", "x"]


def test_plot(tmp_path):
    GROWTH.plot(tmp_path / "a.png")
    one = np.asarray(Image.open(tmp_path / "a.png").convert("RGB"))
    assert one.shape[0] >= 500 and one.std() > 5.0
    Growth("faces", GROWTH.counts, [{"a": 1.0}, {"a": 2.0}]).plot(tmp_path / "b.png")
    other = np.asarray(Image.open(tmp_path / "b.png").convert("RGB"))
    assert not np.array_equal(one, other)
