from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["mesh_map", "mesh_map.layers", "mesh_map.opencl"],
        package_dir={"": "src"},
    )
)
