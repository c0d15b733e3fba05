"""Files that a stranger may have made, read as data: nothing in them is run, and sizes are checked before reading.

Every file of the suite is read here: levels, plans, hyperparameters, tables of chances, policies. YAML has one meaning
everywhere, and a stricter one than PyYAML's:

* A key stands once in a mapping; a second one is an error. The merge key `<<` works.
* A number is decimal: `10`, `010` (ten), `-.5`, `1e-3`, `1_000`, `.inf`, `.nan`. All else is text, `1:30`, `0x1F` and
  dates too.
"""

from __future__ import annotations

import errno
import json
import os
import re
import stat
import zlib
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, BinaryIO, Final, cast
from zipfile import BadZipFile, ZipFile, ZipInfo

import numpy as np
import yaml
from numpy.typing import NDArray
from yaml.composer import ComposerError
from yaml.constructor import ConstructorError

from pnt_gym.errors import PntGymError, one_sentence

MOST_TEXT: Final = 2**18
"""Bytes of a level, a plan or the like; PyYAML takes two seconds for so many brackets."""
MOST_NODES: Final = 10**5
"""Values in a YAML file, with those that aliases repeat."""
MOST_NUMBERS: Final = 2**26
"""Bytes of the arrays in a file; a network of three layers of 2,000 has half as many."""
MOST_PARTS: Final = 1000
"""Files in an archive."""
INTEGER: Final = re.compile(r"[-+]?[0-9][0-9_]*")
DECIMAL: Final = re.compile(r"[-+]?(?:[0-9][0-9_]*(?:\.[0-9_]*)?|\.[0-9][0-9_]*)(?:[eE][-+]?[0-9]+)?")
SPECIAL: Final = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")


class ReadError(PntGymError):
    """A file that is not what is to be read; the message tells why, without the file's name and content."""


class AccessError(ReadError):
    """A file that is not there, no regular file, or too large; the content was not looked at."""


@contextmanager
def opened(path: str | Path, most: int) -> Generator[BinaryIO, None, None]:
    """A regular file of a bounded size, open for reading.

    Args:
        path: of the file.
        most: bytes that it may have.

    Raises:
        AccessError: there is no such file, it is a folder, a device or a pipe, or it is larger.
    """
    try:
        # Without O_NONBLOCK the opening of a pipe waits for somebody who writes.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except OSError as error:
        raise AccessError(error.strerror or str(error)) from None
    except ValueError:  # a NUL in the name
        raise AccessError("no file can have this name") from None
    kind = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(kind):
        os.close(descriptor)
        raise AccessError(os.strerror(errno.EISDIR) if stat.S_ISDIR(kind) else "it is no regular file")
    with os.fdopen(descriptor, "rb") as file:
        _check_size("it", os.fstat(descriptor).st_size, most)
        yield cast("BinaryIO", file)


def _check_size(what: str, size: int, most: int) -> None:
    if size > most:
        raise AccessError(f"{what} has {size:,} bytes; at most {most:,} are read")


def bytes_of(path: str | Path, most: int) -> bytes:
    """The content of a file.

    Args:
        path: of the file.
        most: bytes that it may have.

    Raises:
        AccessError: there is no such file, or it is too large.
    """
    with opened(path, most) as file:
        try:
            data = file.read(most + 1)  # files of /proc have size 0
        except OSError as error:
            raise AccessError(error.strerror or str(error)) from None
    _check_size("it", len(data), most)
    return data


def text_of(path: str | Path, most: int = MOST_TEXT, form: str = "text") -> str:
    """The text of a file.

    Args:
        path: of the file.
        most: bytes that it may have.
        form: what the file should hold, for the error.

    Raises:
        ReadError: there is no such file, it is too large, or no text.
    """
    data = bytes_of(path, most)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise ReadError(f"it is not valid {form}: byte {error.start + 1} is not UTF-8") from None


def json_of(path: str | Path, most: int = MOST_TEXT) -> Any:
    """The data of a JSON file; arguments and errors are those of `text_of`, and text that is not JSON."""
    return parsed_json(text_of(path, most, "JSON"))


def parsed_json(text: str | bytes) -> Any:
    """The data of JSON text.

    Raises:
        ReadError: it is not JSON, a key stands twice in an object, or its brackets are too deep.
    """
    try:
        return json.loads(text, object_pairs_hook=_single_keys)
    except json.JSONDecodeError as error:
        raise ReadError(f"it is not valid JSON: {error.msg}: line {error.lineno} column {error.colno}") from None
    except (RecursionError, ValueError) as error:
        raise ReadError(f"it is not valid JSON: {_cause(error)}") from None


def _single_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object.

    Raises:
        ValueError: a key stands twice in it.
    """
    data = dict(pairs)
    if len(data) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"key {one_sentence(repr(twice), 60)} stands twice")
    return data


def yaml_of(path: str | Path, most: int = MOST_TEXT, loader: type[PlainLoader] | None = None) -> Any:
    """The data of a YAML file; arguments and errors are those of `text_of`, and text that is not valid YAML.

    `loader` understands more tags.
    """
    return parsed_yaml(text_of(path, most, "YAML"), loader)


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
        raise ReadError(f"it is not valid YAML: {_cause(error)}") from None


def _cause(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return "its brackets are too deep"
    return one_sentence(error, 100)


class PlainLoader(yaml.SafeLoader):
    """YAML as this module's head says."""

    def get_single_data(self) -> Any:
        """The data of the one document; PyYAML calls it."""
        node = self.get_single_node()
        if node is None:
            return None
        _count(node, {})
        return cast("Any", self).construct_document(node)

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        """A mapping before aliases are merged into it; no key stands in it twice."""
        node = super().compose_mapping_node(anchor)
        keys: set[Any] = set()
        for key_node, _ in node.value:
            key = self._key_of(key_node)
            if key in keys:
                raise ComposerError(
                    None, None, f"key {one_sentence(repr(key_node.value), 60)} stands twice", key_node.start_mark
                )
            keys.add(key)
        return node

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Merge what `<<` names into a mapping; PyYAML calls it, and its own versions differ.

        A mapping's own keys go before merged ones, and of several merged mappings the first one does.
        """
        own = [pair for pair in node.value if pair[0].tag != _MERGE]
        sources = [value for key, value in node.value if key.tag == _MERGE]
        kept, keys = list[Any](), {self._key_of(key) for key, _ in own}
        for source in sources:
            for part in source.value if isinstance(source, yaml.SequenceNode) else [source]:
                if not isinstance(part, yaml.MappingNode):
                    raise ConstructorError(None, None, "<< merges mappings", part.start_mark)
                self.flatten_mapping(part)
                fresh = [pair for pair in part.value if self._key_of(pair[0]) not in keys]
                keys |= {self._key_of(key) for key, _ in fresh}
                kept += fresh
        node.value = kept + own

    def _key_of(self, node: yaml.Node) -> Any:
        """What makes a key another one than its neighbours: `1` and `01` are the same."""
        if not isinstance(node, yaml.ScalarNode):
            return id(node)
        return node.tag, number_of(node.value) if node.tag in (_INT, _FLOAT) else node.value


_INT: Final = "tag:yaml.org,2002:int"
_FLOAT: Final = "tag:yaml.org,2002:float"
_MERGE: Final = "tag:yaml.org,2002:merge"
_TIME: Final = "tag:yaml.org,2002:timestamp"


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
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in (_INT, _FLOAT, _TIME)]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
for _tag, _pattern in ((_INT, INTEGER), (_FLOAT, DECIMAL), (_FLOAT, SPECIAL)):
    for _reader in (PlainLoader, PlainDumper):
        cast("Any", _reader).add_implicit_resolver(_tag, re.compile(f"(?:{_pattern.pattern})$"), list("-+.0123456789"))
for _tag in (_INT, _FLOAT):
    PlainLoader.add_constructor(_tag, _number)


def yaml_text(data: Any, **layout: Any) -> str:
    """YAML that is read as the same data, in the order in which the data come; `layout` is PyYAML's."""
    return cast("str", yaml.dump(data, Dumper=PlainDumper, sort_keys=False, **layout))


def _count(node: yaml.Node, sizes: dict[int, int]) -> int:
    """Values in a node, with those that aliases repeat.

    Raises:
        ReadError: there are too many, or the node stands in itself.
    """
    if id(node) in sizes:
        if sizes[id(node)] == 0:
            raise ReadError("it is not valid YAML: a value refers to itself")
        return sizes[id(node)]
    sizes[id(node)] = 0
    parts: list[yaml.Node] = []
    if isinstance(node, yaml.MappingNode):
        parts = [part for pair in node.value for part in pair]
    elif isinstance(node, yaml.SequenceNode):
        parts = node.value
    size = 1 + sum(_count(part, sizes) for part in parts)
    if size > MOST_NODES:
        raise ReadError(f"it has more than {MOST_NODES:,} values, with those that aliases repeat")
    sizes[id(node)] = size
    return size


def arrays_of(path: str | Path, expected: re.Pattern[str], most: int = MOST_NUMBERS) -> dict[str, NDArray[Any]]:
    """The arrays of a NumPy archive (.npz), by name; none of them holds objects.

    Args:
        path: of the archive.
        expected: matches the whole name of every array that may stand in it.
        most: bytes of all arrays, and of the file.

    Raises:
        ReadError: there is no such archive, it holds something else, or it is too large.
    """
    with archive(path, expected, most, ".npy") as (parts, infos):
        return {info.filename.removesuffix(".npy"): _array(parts, info) for info in infos}


@contextmanager
def archive(
    path: str | Path | BinaryIO, expected: re.Pattern[str], most: int, suffix: str = ""
) -> Generator[tuple[ZipFile, list[ZipInfo]], None, None]:
    """A zip archive and what stands in it, of which names and sizes are checked.

    Args:
        path: of the archive, or an open one.
        expected: matches the whole name of every part, without the suffix.
        most: bytes of all parts together when they are unpacked.
        suffix: of every part's name.

    Raises:
        ReadError: there is no such archive, it is torn, it holds something else, or it is too large.
    """
    try:
        if not isinstance(path, str | Path):
            yield _directory(path, expected, most, suffix)
            return
        with opened(path, most) as file:
            yield _directory(file, expected, most, suffix)
    except (BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError, ValueError) as error:
        # What the standard library says of an archive that is torn, encrypted or packed in an unusual way.
        if isinstance(error, PntGymError):
            raise
        raise ReadError(f"it is no archive that can be read: {one_sentence(error, 100)}") from None


def _directory(file: BinaryIO, expected: re.Pattern[str], most: int, suffix: str) -> tuple[ZipFile, list[ZipInfo]]:
    parts = ZipFile(file)
    infos = parts.infolist()
    if len(infos) > MOST_PARTS:
        raise ReadError(f"it holds {len(infos):,} parts; at most {MOST_PARTS:,} are read")
    names = [info.filename for info in infos]
    for name in names:
        if not (name.endswith(suffix) and expected.fullmatch(name.removesuffix(suffix))):
            raise ReadError(f"it holds {one_sentence(repr(name), 60)}, which does not belong there")
        if names.count(name) > 1:
            raise ReadError(f"it holds {name!r} twice")
    _check_size("what it holds", sum(info.file_size for info in infos), most)
    return parts, infos


def _array(parts: ZipFile, info: ZipInfo) -> NDArray[Any]:
    """An array of an archive whose header promises as many bytes as there are."""
    with parts.open(info) as file:
        version = np.lib.format.read_magic(file)
        readers: dict[tuple[int, int], Callable[[IO[bytes]], tuple[tuple[int, ...], bool, np.dtype[Any]]]] = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }
        if version not in readers:
            raise ReadError(f"it holds {info.filename!r} in version {version} of NumPy's format")
        shape, _, kind = readers[version](file)
        size = kind.itemsize
        for length in shape:
            size *= length
        if kind.hasobject or min(shape, default=0) < 0 or size != info.file_size - file.tell():
            raise ReadError(f"it holds {info.filename!r}, whose header and content do not fit together")
    with parts.open(info) as file:
        return np.lib.format.read_array(file, allow_pickle=False)
