"""The C++ sides of benchmarks: where they are, and what they print."""

import os
import subprocess
from typing import Dict, List, Optional, Sequence


def find_program(name: str) -> Optional[str]:
    """The path of a C++ program of this package, None where it was not built."""
    command = ["catkin_find", "--first-only", "--libexec", "mesh_tools_test", name]
    found = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False
    ).stdout.decode()
    path = found.strip()
    return path if path and os.path.isfile(path) else None


def lines_in_rviz(program: str, arguments: Sequence[str], seconds: float) -> List[List[str]]:
    """The words of each line that a program prints, with a ROS master and without a screen.

    :raises RuntimeError: with the end of its errors, if it fails or takes longer.
    """
    command = ["rosrun", "osmesa_harness", "headless", "--master", "--timeout", str(seconds)]
    done = subprocess.run(
        command + [program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False
    )
    if done.returncode != 0:
        errors = done.stderr.decode(errors="replace").strip().splitlines()[-5:]
        name = os.path.basename(program)
        raise RuntimeError(f"{name} {' '.join(arguments)} ended with {done.returncode}: {errors}")
    lines = [line.split() for line in done.stdout.decode(errors="replace").splitlines()]
    return [line for line in lines if line and is_name(line[0])]  # RViz and OGRE print there, too


def is_name(word: str) -> bool:
    """Whether a line may begin with that."""
    return word.replace("_", "").isalpha() and word.islower()


def run_in_rviz(program: str, arguments: Sequence[str], seconds: float) -> Dict[str, float]:
    """The lines "name value" that a program prints; errors as of lines_in_rviz()."""
    lines = lines_in_rviz(program, arguments, seconds)
    return {line[0]: float(line[1]) for line in lines if len(line) == 2}
