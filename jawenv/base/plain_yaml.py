"""YAML as people expect it: plain data, 1e-4 is a number, a key appears once. Needs the package pyyaml."""

from __future__ import annotations

import re
from typing import Any

import yaml

from jawenv.base.errors import shown

MOST_VALUES = 200_000
"""Values in a text, where each alias counts as all that it stands for."""
LONGEST_TEXT = 2**20
"""Characters of a text: pyyaml takes a second for them."""
LONGEST_NUMBER = 1000
"""Characters of a number."""


class _Loader(yaml.SafeLoader):
    """SafeLoader that refuses repeated keys, and texts that say more than they hold."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._values = 0
        self._values_of_anchor: dict[str, int] = {}

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose a node and count its values; aliases of aliases could make of a short text more than memory holds."""
        event, before = self.peek_event(), self._values
        if isinstance(event, yaml.AliasEvent):
            # An anchor is counted when its value is complete.
            if event.anchor in self.anchors and event.anchor not in self._values_of_anchor:
                raise ValueError(f"alias '{event.anchor}' stands in its own value")
            self._values += self._values_of_anchor.get(event.anchor or "", 0)
        else:
            self._values += 1
        if self._values > MOST_VALUES:
            raise ValueError(f"more than {MOST_VALUES:,} values, aliases written out")
        node = super().compose_node(parent, index)
        if event.anchor is not None and not isinstance(event, yaml.AliasEvent):
            self._values_of_anchor[event.anchor] = self._values - before
        return node

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = set()
        for key_node, _ in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                raise ValueError(f"found unhashable key (line {key_node.start_mark.line + 1})")
            key = str(key_node.value)
            if key in keys and key != "<<":
                raise ValueError(f"key {shown(key)} appears twice")
            keys.add(key)
        return super().construct_mapping(node, deep)

    def construct_number(self, node: yaml.ScalarNode) -> int | float:
        """A number of a sane length: YAML 1.1 has numbers to the base of 60, whose time grows with the square."""
        if len(node.value) > LONGEST_NUMBER:
            raise ValueError(f"a number of more than {LONGEST_NUMBER} characters (line {node.start_mark.line + 1})")
        whole = node.tag == "tag:yaml.org,2002:int"
        number: int | float = self.construct_yaml_int(node) if whole else self.construct_yaml_float(node)
        return number


# pyyaml follows YAML 1.1, which takes a number without a point before the exponent for text.
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+$"),
    list("-+0123456789"),
)
for _kind in ("int", "float"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_kind}", _Loader.construct_number)


def parse(text: str) -> Any:
    """The data in a YAML text.

    Raises:
        ValueError: damaged text, a repeated key, or more values than `MOST_VALUES`.
    """
    if len(text) > LONGEST_TEXT:
        raise ValueError(f"{len(text):,} characters; allowed: {LONGEST_TEXT:,} at most (JSON and TOML may be longer)")
    try:
        return yaml.load(text, _Loader)
    except yaml.MarkedYAMLError as error:
        line = f" (line {error.problem_mark.line + 1})" if error.problem_mark else ""
        raise ValueError(f"{error.problem}{line}") from None
    except yaml.YAMLError as error:
        raise ValueError(error) from None
    except (LookupError, AttributeError, TypeError, ArithmeticError) as error:  # a tag before a value of another kind
        raise ValueError(f"a value that its tag does not fit ({type(error).__name__}: {error})") from None
