from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["mesh_msgs_hdf5", "mesh_msgs_hdf5.commands", "mesh_msgs_hdf5.formats"],
        package_dir={"": "src"},
    )
)
