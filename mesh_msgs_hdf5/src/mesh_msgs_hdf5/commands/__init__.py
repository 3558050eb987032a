"""The verbs of mesh_tool, one module each.

Each has NAME, HELP, EXAMPLE, add_arguments(parser), run(arguments) -> exit code.
"""
