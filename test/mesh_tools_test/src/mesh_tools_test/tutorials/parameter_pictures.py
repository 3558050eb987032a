"""Pictures of what each parameter does to layers, paths, drives, commands and reconstructed maps.

python3 -m mesh_tools_test.tutorials.parameter_pictures [FOLDER] [--only layers …]
"""
import argparse
from pathlib import Path

from mesh_tools_test.tutorials import (
    drive_pictures,
    guard_pictures,
    layer_pictures,
    planner_pictures,
    reconstruction_pictures,
)

KINDS = {
    "layers": layer_pictures.all_pictures,
    "planners": planner_pictures.all_pictures,
    "controller": drive_pictures.all_pictures,
    "guard": guard_pictures.all_pictures,
    "reconstruction": reconstruction_pictures.all_pictures,
}


def main() -> None:
    """Write them into a folder, by default this one."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path())
    parser.add_argument("--only", nargs="+", choices=KINDS, default=list(KINDS))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for kind in options.only:
        KINDS[kind](options.folder)


if __name__ == "__main__":
    main()
