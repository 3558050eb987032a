"""Declared parameters in the form that dynamic_reconfigure wants."""

import ast
import math

import pytest
from dynamic_reconfigure.encoding import (
    decode_config,
    decode_description,
    encode_config,
    encode_description,
    extract_params,
)
from mesh_map.base.parameter import Parameter
from mesh_map.costs.settings import SETTINGS
from mesh_map.ros.reconfigure_type import ConfigType, is_described

ALL = (
    Parameter("threshold", 0.5, 0.1, 2.0, "of the costs (m)"),
    Parameter("height", 2.0, 0.0, math.inf),
    Parameter("free", -1.0),
    Parameter("size", 3, 0, 100000),
    Parameter("count", 3),
    Parameter("on", True),
    Parameter("topic", "points"),
    Parameter("mode", "sum", description="how", choices=("", "sum", "max")),
    Parameter("names", ("a",)),
    Parameter("table", {}),
)


def test_it_survives_the_wire():
    """What a client of dynamic_reconfigure makes of the description."""
    described = extract_params(decode_description(encode_description(ConfigType(ALL))))
    found = {one["name"]: one for one in described}
    limits = {name: (one["min"], one["max"], one["default"]) for name, one in found.items()}
    assert limits == {
        "threshold": (0.1, 2.0, 0.5),
        "height": (0.0, math.inf, 2.0),
        "free": (-math.inf, math.inf, -1.0),
        "size": (0, 100000, 3),
        "count": (-(2**31), 2**31 - 1, 3),
        "on": (False, True, True),
        "topic": ("", "", "points"),
        "mode": ("", "", "sum"),
    }
    types = [one["type"] for one in described]
    assert types == ["double", "double", "double", "int", "int", "bool", "str", "str"]
    assert found["threshold"]["description"] == "of the costs (m)"


def test_numbers_keep_their_type():
    """A limit of the other type would be sent in a list where clients do not look for it."""
    config = ConfigType((Parameter("a", 1.0, 0, 2), Parameter("b", 1, 0.0, 2.0)))
    for values in (config.min, config.max, config.defaults):
        assert [type(values[name]) for name in "ab"] == [float, int]
        assert decode_config(encode_config(values)) == values


def test_choices_are_an_enum():
    config = ConfigType(ALL)
    methods = {one["name"]: one["edit_method"] for one in config.config_description["parameters"]}
    enum = ast.literal_eval(methods["mode"])
    assert enum["enum_description"] == "how"
    assert [(one["name"], one["value"], one["type"]) for one in enum["enum"]] == [
        ("none", "", "str"),
        ("sum", "sum", "str"),
        ("max", "max", "str"),
    ]
    assert methods["topic"] == methods["threshold"] == ""


@pytest.mark.parametrize("parameter", ALL + SETTINGS, ids=lambda parameter: parameter.name)
def test_what_has_a_type_is_described(parameter):
    described = parameter.name not in ("names", "table")
    assert is_described(parameter) == described
    assert (parameter.name in ConfigType((parameter,)).defaults) == described
