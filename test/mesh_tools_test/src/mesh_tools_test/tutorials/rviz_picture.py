"""A picture of RViz for a page: on a virtual screen, as soon as it is still."""
import argparse
import os
import sys
from pathlib import Path

import numpy as np
import yaml
from osmesa_harness.back_ends import BackEnd, environment_of
from PIL import Image

from mesh_tools_test.demo.processes import process
from mesh_tools_test.demo.screenshot import STATUS_BAR, settled_picture, window_of

LEAST = (800, 600)  # pixels; what is smaller is a dialog
FRAME_RATE = 5  # per second: each frame is drawn by the processor, which others need meanwhile


def slowed_down(config, folder):
    """A copy of a configuration of RViz that draws no more frames than are needed."""
    content = yaml.safe_load(config.read_text(encoding="utf-8"))
    options = content["Visualization Manager"].setdefault("Global Options", {})
    options["Frame Rate"] = FRAME_RATE
    folder.mkdir(parents=True, exist_ok=True)
    slow = folder / config.name
    slow.write_text(yaml.safe_dump(content), encoding="utf-8")
    return slow


def main():
    """Run RViz with a configuration, save what the screen shows once it does not change."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config", type=Path, help=".rviz file")
    parser.add_argument("picture", type=Path, help="PNG to write")
    options = parser.parse_args()
    logs = options.picture.resolve().parent / "logs"
    config = slowed_down(options.config, logs)
    with environment_of(BackEnd.OSMESA_X, os.environ) as environment:
        command = ["rviz", "--disable-anti-aliasing", "-d", str(config)]
        with process("rviz", command, logs, environment) as rviz:
            picture = settled_picture(environment, rviz)
    # without the status bar, whose frame rate is ours
    picture = Image.fromarray(window_of(np.asarray(picture))[:-STATUS_BAR])
    picture.save(options.picture)
    if picture.width < LEAST[0] or picture.height < LEAST[1]:
        sys.exit(f"{options.picture}: {picture.width} x {picture.height} pixels: no RViz is seen")


if __name__ == "__main__":
    main()
