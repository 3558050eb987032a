"""The mesh map on ROS: its server, and what layers get from topics."""

from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.ros.log import forward_log
from mesh_map.ros.mesh_map_server import MeshMapServer

__all__ = ["COMBINED_COSTS", "MeshMapServer", "forward_log"]
