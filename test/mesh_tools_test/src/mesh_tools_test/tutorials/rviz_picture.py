"""A picture of RViz for a page: on a virtual screen, as soon as it is still."""
import argparse
import os
import sys
from pathlib import Path

import numpy as np
from osmesa_harness.back_ends import BackEnd, environment_of

from mesh_tools_test.demo.processes import process
from mesh_tools_test.demo.screenshot import settled_picture


LEAST = (800, 600)  # pixels; what is smaller is a dialog


def without_screen(picture):
    """A picture of the screen without what of it lies beside the window: black at its lower and
    right edge."""
    drawn = np.asarray(picture).any(axis=2)
    height, width = (np.flatnonzero(drawn.any(axis=axis)).max(initial=0) + 1 for axis in (1, 0))
    return picture.crop((0, 0, int(width), int(height)))


def main():
    """Run RViz with a configuration, save what the screen shows once it does not change."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config", type=Path, help=".rviz file")
    parser.add_argument("picture", type=Path, help="PNG to write")
    options = parser.parse_args()
    with environment_of(BackEnd.OSMESA_X, os.environ) as environment:
        command = ["rviz", "--disable-anti-aliasing", "-d", str(options.config.resolve())]
        logs = options.picture.resolve().parent / "logs"
        with process("rviz", command, logs, environment) as rviz:
            picture = settled_picture(environment, rviz)
    picture = without_screen(picture)
    picture.save(options.picture)
    if picture.width < LEAST[0] or picture.height < LEAST[1]:
        sys.exit(f"{options.picture}: {picture.width} x {picture.height} pixels: no RViz is seen")


if __name__ == "__main__":
    main()
