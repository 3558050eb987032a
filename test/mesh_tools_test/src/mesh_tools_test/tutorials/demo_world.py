"""What `./run demo` leaves and tutorials begin with: demo/outdoor_world.ply, of fewer faces."""
import sys
from pathlib import Path

from mesh_tools_test.demo.pipeline import generate_world
from mesh_tools_test.demo.report import Report

FACES = 30_000


def main():
    """Write it below a folder, by default this one."""
    path = Path(*sys.argv[1:2], "demo", "outdoor_world.ply")
    path.parent.mkdir(parents=True, exist_ok=True)
    generate_world(Report(), path, FACES, seed=0)


if __name__ == "__main__":
    main()
