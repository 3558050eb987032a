"""Verbs of mesh_tool called in this process."""

import argparse
import importlib
import json


def call(verb, *words):
    """The exit code of a verb with these arguments, --json is added."""
    module = importlib.import_module("mesh_map.commands." + verb)
    parser = argparse.ArgumentParser()
    module.add_arguments(parser)
    return module.run(parser.parse_args([*map(str, words), "--json"]))


def said(capsys, verb, *words):
    """What it says for programs."""
    assert call(verb, *words) == 0
    return json.loads(capsys.readouterr().out)
