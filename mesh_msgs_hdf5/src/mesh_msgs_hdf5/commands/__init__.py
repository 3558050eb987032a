"""The verbs of mesh_tool, one module each: NAME, HELP, EXAMPLE, add_arguments(parser),
run(arguments) -> exit code.
"""
