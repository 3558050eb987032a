from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "mesh_tools_test",
            "mesh_tools_test.base",
            "mesh_tools_test.demo",
            "mesh_tools_test.display",
            "mesh_tools_test.driving",
            "mesh_tools_test.faults",
            "mesh_tools_test.layers",
            "mesh_tools_test.planning",
            "mesh_tools_test.spatial",
        ],
        package_dir={"": "src"},
    )
)
