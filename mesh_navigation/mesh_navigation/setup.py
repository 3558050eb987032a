from setuptools import setup

from catkin_pkg.python_setup import generate_distutils_setup

setup(
    **generate_distutils_setup(
        packages=[
            "mesh_navigation",
            "mesh_navigation.controllers",
            "mesh_navigation.planners",
            "mesh_navigation.recoveries",
            "mesh_navigation.simulation",
        ],
        package_dir={"": "src"},
    )
)
