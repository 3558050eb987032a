"""The files that a demo leaves beside the map."""
from mesh_tools_test.demo.layers import PICTURES
from mesh_tools_test.demo.planners import DIJKSTRA, WAVE_FRONT

# RViz with the potential of a planner; that of the last one stays on the screen
POTENTIALS = ((DIJKSTRA, "dijkstra.png"), (WAVE_FRONT, "wave_front.png"))
RVIZ_PICTURE = "rviz.png"  # with the robot at the goal, and its track; the only one of --short
GRID = "grid.png"
REPORT = "report.md"
LAYERS, PLANNERS, RVIZ = "layers.yaml", "planners.yaml", "mesh_tools.rviz"

# What would speak of a success, were it left from an earlier run.
SUCCESS = (
    GRID,
    *(name for _, name in POTENTIALS),
    *(name for name, _, _ in PICTURES),
    REPORT,
)
FILES = (*SUCCESS, LAYERS, PLANNERS, RVIZ)
