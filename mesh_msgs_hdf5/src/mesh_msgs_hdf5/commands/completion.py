"""mesh_tool completion: what makes bash complete the arguments of mesh_tool."""
import argparse

from mesh_msgs_hdf5.completion import bash_script

NAME = "completion"
HELP = "print what makes bash complete mesh_tool's arguments; see the example for .bashrc"
EXAMPLE = 'mesh_tool completion bash  (in .bashrc: eval "$(rosrun ...)")'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=("bash",))


def run(arguments: argparse.Namespace) -> int:
    print(bash_script(), end="")
    return 0
