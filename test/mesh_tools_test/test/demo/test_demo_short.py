"""The short demo as a user runs it: mesh, layers, one plan, one picture."""
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

from mesh_tools_test.demo import results, screenshot

DEMO = Path(__file__).parents[2] / "nodes/demo"
STEPS = ["generate a world", "import", "save the mesh", "topology", "layers", "spatial index"]
STEPS += ["save the layers", "choose poses", "start roscore", "start map and server"]
STEPS += ["plan: Wave front", "picture rviz.png", "all"]


def test_the_short_demo_makes_one_plan_and_one_picture(tmp_path):
    output = tmp_path / "out"
    command = [sys.executable, str(DEMO), "--short", "--headless", "--output", str(output)]
    command += ["--faces", "5000"]
    started = time.monotonic()
    said = subprocess.run(command, capture_output=True, text=True, timeout=240, check=True).stdout
    rows = (output / results.REPORT).read_text(encoding="utf-8").splitlines()[2:]
    assert [row.split("|")[1].strip() for row in rows] == STEPS
    assert float(rows[-1].split("|")[2]) < time.monotonic() - started
    left = {path.name for path in output.glob("*.*")}
    assert {"outdoor_world.h5", "rviz.png", results.REPORT, results.RVIZ} <= left
    assert not left & {"grid.png", "dijkstra.png", "wave_front.png", "roughness.png"}
    assert "rosrun mesh_navigation go_to" in said and "rviz.png, report.md" in said
    picture = np.asarray(Image.open(output / "rviz.png").convert("RGB"))
    # The mesh with its costs fills the view.
    assert screenshot.colored_share(picture) > 0.3
