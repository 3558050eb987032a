"""The real program rviz, on no screen at all."""

import signal
import subprocess
import time
from pathlib import Path
from typing import List, Set, Tuple

import numpy as np
import pytest
from PIL import Image

CONFIG = """
Visualization Manager:
  Class: ""
  Displays:
    - {Class: rviz/Grid, Name: Grid, Enabled: true, Alpha: 1, Color: 255; 0; 0,
       Line Style: {Value: Billboards, Line Width: 0.1}}
  Global Options: {Background Color: 0; 0; 255, Fixed Frame: map, Frame Rate: 30}
  Views:
    Current: {Class: rviz/TopDownOrtho, Name: Current View, Scale: 40, X: 2, Y: 1}
Window Geometry: {Width: 900, Height: 700}
"""
RED = (255, 0, 0)
BLUE = (0, 0, 255)
# Each way 11 lines of 400 x 4 pixels; in the square that both fill they cover 40 x 40 twice.
RED_PIXELS = 2 * 11 * 400 * 4 - 40 * 40


def frames(folder: Path) -> List[Path]:
    return sorted(folder.glob("frame-*.ppm"))


def pixels(path: Path) -> np.ndarray:
    """(height, width, 3) bytes; fails where the file is not whole."""
    with Image.open(str(path)) as image:
        image.load()
        return np.asarray(image)


def share(picture: np.ndarray, color: Tuple[int, int, int]) -> float:
    return float(np.mean(np.all(picture == color, axis=2)))


@pytest.mark.parametrize("options", [[], ["--x-osmesa"]])
def test_rviz_draws_its_view_and_ends_in_peace(script, environment, tmp_path, wait_for, options):
    config = tmp_path / "grid.rviz"
    config.write_text(CONFIG)
    environment["OSMESA_GLX_DUMP"] = str(tmp_path / "frame")
    log = (tmp_path / "output").open("w")
    command = script("headless", "--master", *options, "rviz", "-d", str(config))
    start = time.monotonic()
    rviz = subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT)
    seen: Set[int] = set()

    def drawn() -> bool:
        # Whatever the moment, a frame that is there is whole.
        pictures = [pixels(path) for path in frames(tmp_path)]
        seen.update(path.stat().st_mtime_ns for path in frames(tmp_path))
        return len(seen) >= 4 and any(
            np.sum(np.all(picture == RED, axis=2)) == RED_PIXELS and share(picture, BLUE) > 0.5
            for picture in pictures
        )

    try:
        wait_for(drawn, rviz)
    finally:
        rviz.send_signal(signal.SIGINT)
        status = rviz.wait()
        log.close()
    elapsed = time.monotonic() - start
    assert status == 0, (tmp_path / "output").read_text()

    # One view alone, in its last size; its middle lies right of the origin and above it.
    assert len(frames(tmp_path)) == 1
    picture = pixels(frames(tmp_path)[0])
    assert share(picture, RED) + share(picture, BLUE) == pytest.approx(1.0, abs=0.02)
    rows, columns = np.nonzero(np.all(picture == RED, axis=2))
    assert columns.mean() == pytest.approx(picture.shape[1] / 2 - 80, abs=1)
    assert rows.mean() == pytest.approx(picture.shape[0] / 2 + 40, abs=1)
    assert 500 < picture.shape[1] <= 900 and 400 < picture.shape[0] <= 700
    # At most two a second, though RViz draws thirty.
    assert len(seen) <= 2 * elapsed + 1
    assert not list(tmp_path.glob("*.tmp"))


def test_frames_that_cannot_be_written_do_not_stop_rviz(script, environment, tmp_path, wait_for):
    environment["OSMESA_GLX_DUMP"] = str(tmp_path / "missing" / "frame")
    environment["OSMESA_GLX_VERBOSE"] = "1"
    output = tmp_path / "output"
    with output.open("w") as log:
        rviz = subprocess.Popen(
            script("headless", "--master", "rviz"), env=environment, stdout=log, stderr=log
        )
        try:
            wait_for(lambda: output.read_text().count("cannot write the frame") >= 2, rviz)
        finally:
            rviz.send_signal(signal.SIGINT)
            status = rviz.wait()
    assert status == 0
    lines = output.read_text().splitlines()
    assert any(line.startswith("[osmesa_glx] no X server: a fake display") for line in lines)
    assert any(f"{tmp_path}/missing/frame-" in line and "No such file" in line for line in lines)
