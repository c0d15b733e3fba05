"""YAML that means the same to every reader, and is stricter than PyYAML's.

* A key stands once in a mapping; a second one is an error. The merge key `<<` works.
* A number is decimal: `10`, `010` (ten), `-.5`, `1e-3`, `1_000`, `.inf`, `.nan`; only `true` and `false` are truth
  values. All else is text, `1:30`, `0x1F`, `on` and dates too.

The parser is libyaml's, which reads ten times as fast as PyYAML's own; PyYAML's own gives the same data where a system
lacks libyaml.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import yaml
from yaml.composer import ComposerError
from yaml.constructor import ConstructorError

from pnt_gym.errors import one_sentence
from pnt_gym.reading.files import ReadError, cause_of, text_of

MOST_NODES: Final = 10**5
"""Values in a YAML file, with those that aliases repeat."""
INTEGER: Final = re.compile(r"[-+]?[0-9][0-9_]*")
DECIMAL: Final = re.compile(r"[-+]?(?:[0-9][0-9_]*(?:\.[0-9_]*)?|\.[0-9][0-9_]*)(?:[eE][-+]?[0-9]+)?")
SPECIAL: Final = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
TRUTH: Final = re.compile(r"true|True|TRUE|false|False|FALSE")
_INT: Final = "tag:yaml.org,2002:int"
_FLOAT: Final = "tag:yaml.org,2002:float"
_BOOL: Final = "tag:yaml.org,2002:bool"
_TIME: Final = "tag:yaml.org,2002:timestamp"
_MERGE: Final = "tag:yaml.org,2002:merge"
if TYPE_CHECKING:
    _Loader = yaml.SafeLoader
else:
    _Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def yaml_of(path: str | Path, loader: type[PlainLoader] | None = None) -> Any:
    """The data of a YAML file; errors are those of `text_of`, and text that is not valid YAML.

    `loader` understands more tags.
    """
    return parsed_yaml(text_of(path, form="YAML"), loader)


def parsed_yaml(text: str, loader: type[PlainLoader] | None = None) -> Any:
    """The data of YAML text.

    Raises:
        ReadError: it is not valid YAML, has a key twice, refers to itself, or aliases make it too large.
    """
    try:
        return yaml.load(text, loader or PlainLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = "" if mark is None else f": line {mark.line + 1} column {mark.column + 1}"
        raise ReadError(f"it is not valid YAML: {one_sentence(error.problem or error.context, 100)}{where}") from None
    except ReadError:
        raise
    except Exception as error:
        # PyYAML lets through whatever a tag, a date or a hundred brackets upset.
        raise ReadError(f"it is not valid YAML: {cause_of(error)}") from None


class PlainLoader(_Loader):
    """YAML as this module's head says."""

    def get_single_data(self) -> Any:
        """The data of the one document; PyYAML calls it."""
        node = self.get_single_node()
        if node is None:
            return None
        self._count(node, {})
        return cast("Any", self).construct_document(node)

    def _count(self, node: yaml.Node, sizes: dict[int, int]) -> int:
        """Values in a node, with those that aliases repeat.

        Raises:
            ReadError: there are too many, or the node stands in itself.
            ComposerError: a key stands twice in a mapping.
        """
        if id(node) in sizes:
            if sizes[id(node)] == 0:
                raise ReadError("it is not valid YAML: a value refers to itself")
            return sizes[id(node)]
        sizes[id(node)] = 0
        size = 1 + sum(self._count(part, sizes) for part in self._parts(node))
        if size > MOST_NODES:
            raise ReadError(f"it has more than {MOST_NODES:,} values, with those that aliases repeat")
        sizes[id(node)] = size
        return size

    def _parts(self, node: yaml.Node) -> Iterator[yaml.Node]:
        """Nodes within a node; the keys of a mapping differ from each other, before aliases are merged into it."""
        if isinstance(node, yaml.SequenceNode):
            yield from node.value
        elif isinstance(node, yaml.MappingNode):
            keys: set[Any] = set()
            for key_node, value in node.value:
                yield from (key_node, value)
                key = self._key_of(key_node)
                if key in keys:
                    text = one_sentence(repr(key_node.value), 60)
                    raise ComposerError(None, None, f"key {text} is given twice", key_node.start_mark)
                keys.add(key)

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Merge what `<<` names into a mapping; PyYAML calls it, and its own versions differ.

        A mapping's own keys go before merged ones, and of several merged mappings the first one does.
        """
        own = {self._key_of(key): (key, value) for key, value in node.value if key.tag != _MERGE}
        merged: dict[Any, Any] = {}
        for source in (value for key, value in node.value if key.tag == _MERGE):
            for part in source.value if isinstance(source, yaml.SequenceNode) else [source]:
                if not isinstance(part, yaml.MappingNode):
                    raise ConstructorError(None, None, "<< merges mappings", part.start_mark)
                self.flatten_mapping(part)
                for key, value in part.value:
                    merged.setdefault(self._key_of(key), (key, value))
        node.value = [pair for key, pair in merged.items() if key not in own] + list(own.values())

    def _key_of(self, node: yaml.Node) -> Any:
        """What makes a key another one than its neighbours: `1` and `01` are the same."""
        if not isinstance(node, yaml.ScalarNode):
            return id(node)
        return node.value if node.tag == _MERGE else cast("Any", self).construct_object(node)


def number_of(text: str) -> int | float | None:
    """The decimal number that a text says; None if it says none."""
    if INTEGER.fullmatch(text):
        return int(text.replace("_", ""))
    if DECIMAL.fullmatch(text):
        return float(text.replace("_", ""))
    return float(text.replace(".", "")) if SPECIAL.fullmatch(text) else None


def _number(loader: PlainLoader, node: yaml.ScalarNode) -> int | float:
    number = number_of(str(loader.construct_scalar(node)))
    if number is None or (node.tag == _INT and not isinstance(number, int)):
        kind = "whole number" if node.tag == _INT else "number"
        raise ConstructorError(None, None, f"the text is no decimal {kind}", node.start_mark)
    return float(number) if node.tag == _FLOAT else number


class PlainDumper(yaml.SafeDumper):
    """Writes text in quotes where this module or PyYAML would read something else."""


PlainLoader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in (_INT, _FLOAT, _BOOL, _TIME)]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
for _reader in (PlainLoader, PlainDumper):
    for _tag, _pattern in ((_INT, INTEGER), (_FLOAT, DECIMAL), (_FLOAT, SPECIAL), (_BOOL, TRUTH)):
        cast("Any", _reader).add_implicit_resolver(
            _tag, re.compile(f"(?:{_pattern.pattern})$"), list("tTfF" if _tag == _BOOL else "-+.0123456789")
        )
for _tag in (_INT, _FLOAT):
    PlainLoader.add_constructor(_tag, _number)


def yaml_text(data: Any, **layout: Any) -> str:
    """YAML that is read as the same data, in the order in which the data come; `layout` is PyYAML's."""
    return cast("str", yaml.dump(data, Dumper=PlainDumper, sort_keys=False, **layout))
