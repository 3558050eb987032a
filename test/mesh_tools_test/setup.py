from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

# What makes and checks the site works on the source tree alone, and needs Sphinx.
SITE = ["mesh_tools_test." + room for room in ("reference", "site", "troubleshooting", "tutorials")]

setup(
    **generate_distutils_setup(packages=find_packages("src", exclude=SITE), package_dir={"": "src"})
)
