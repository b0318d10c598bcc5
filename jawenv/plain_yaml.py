"""YAML as people expect it: plain data, 1e-4 is a number, a key appears once. Needs the package pyyaml."""

from __future__ import annotations

import re
from typing import Any

import yaml

__all__ = ["parse"]


class _Loader(yaml.SafeLoader):
    """SafeLoader that refuses repeated keys."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = set()
        for key_node, _ in node.value:
            key = str(key_node.value)
            if key in keys and key != "<<":
                raise ValueError(f"key '{key}' appears twice")
            keys.add(key)
        return super().construct_mapping(node, deep)


# pyyaml follows YAML 1.1, which takes a number without a point before the exponent for text.
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"),
    list("-+0123456789"),
)


def parse(text: str) -> Any:
    """The data in a YAML text.

    Raises:
        ValueError: damaged text or a repeated key.
    """
    try:
        return yaml.load(text, _Loader)
    except yaml.MarkedYAMLError as error:
        line = f" (line {error.problem_mark.line + 1})" if error.problem_mark else ""
        raise ValueError(f"{error.problem}{line}") from None
    except yaml.YAMLError as error:
        raise ValueError(error) from None
