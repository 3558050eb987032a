"""The files that a demo leaves beside the map."""
from mesh_tools_test.demo import pictures

GRID = "grid.png"
REPORT = "report.md"
LAYERS, PLANNERS, RVIZ = "layers.yaml", "planners.yaml", "mesh_tools.rviz"

# What would speak of a success, were it left from an earlier run.
SUCCESS = (GRID, *(picture.file for picture in pictures.ALL), REPORT)
FILES = (*SUCCESS, LAYERS, PLANNERS, RVIZ)
