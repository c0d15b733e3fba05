"""One change in a file: of a value, a key, a cell, an array or a byte, by what the file's ending says it is."""

from __future__ import annotations

import csv
import io
import json
import re
import warnings
import zipfile
from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import reduce
from operator import getitem
from pathlib import PurePath
from typing import Any, Final

import numpy as np

from benchmarks.fuzz_cases.basis import Draws
from pnt_gym.reading import PlainLoader, parsed_yaml, yaml_text

Place = tuple[Any, ...]
"""Keys and indices that lead to a value in a document."""
MARK: Final = "zzMARKzz"
"""Stands for a value or a key until the text is written, so that anything at all can be put there."""
DEEP: Final = 3000
"""Brackets in brackets."""
TEXTS: Final = (
    "",
    "x",
    "x" * 400,
    "1.0",
    "true",
    "a/b",
    "../x",
    "..",
    "a\\nb",
    "\\u202ea",
    "\\u0000",
    "nominal",
    "ü ö",
)
NUMBERS: Final = (
    "0", "-1", "1", "2", "1.5", "-0.0", "1e-300", "5e-324", "1e30", "-1e308", "1e999", "9" * 25, "9" * 400, "9" * 5000,
    "2147483648", "1e6", "1000000",
)  # fmt: skip
JSON_VALUES: Final = (
    *NUMBERS, *(f'"{text}"' for text in TEXTS), "null", "true", "false", "[]", "{}", "[[]]", "[null]", "[1.0]",
    "[1, 2]", '{"x": 1.0}', '{"name": "x"}', "NaN", "Infinity", "-Infinity", '"\\ud800"', "[" * DEEP + "]" * DEEP, "",
    "[" + ", ".join(["1.0"] * 5000) + "]",
)  # fmt: skip
YAML_VALUES: Final = (
    *NUMBERS, *(f'"{text}"' for text in TEXTS), "null", "true", "[]", "{}", "[[]]", "[null]", "[1.0]", "[1, 2]",
    "{x: 1.0}", "{name: x}", ".nan", ".inf", "-.inf", "~", "yes", "0x1F", "1:30", "2020-01-01", "!!binary aGk=",
    "!!set {a, b}", "!!python/name:os.system x", "!!timestamp 2020-13-45", "!!float x", "!x y", "*nobody", "&a [*a]",
    "{1: 2, [3]: 4}", "{? [a, b] : c}", "[" * DEEP + "]" * DEEP, "", "[" + ", ".join(["1.0"] * 5000) + "]", "@", "`x`",
    "'", '"', "|", "%TAG", "- x", "x: y",
)  # fmt: skip
CELLS: Final = (
    *NUMBERS, "nan", "inf", "-inf", "NaN", "None", "null", "true", "False", "x", "x" * 300, "1,5", "1;5", "0x10",
    "1_000", "٣", "1e400", '"', '""', "'", "\x00", " ", "=1+1", "1.0.0", "+-1", "\u202e1", "🙂",
)  # fmt: skip
KEYS: Final = ("typo", "5", "null", "", "<<", "x" * 300, "a/b", "\u202e")
FACTORS: Final = (
    0.0,
    -1.0,
    1e-9,
    1e-6,
    1e-3,
    0.01,
    0.5,
    0.9,
    1.1,
    2.0,
    3.6,
    10.0,
    57.3,
    100.0,
    1e3,
    1e6,
    1e9,
    1e12,
    1e300,
)
KINDS: Final = ("f8", "f4", "f2", "i8", "i4", "u1", "?", "c16", "U7", "S3", "M8[s]", "m8[s]", ">f4", "O", "f4,i4")
"""Types of NumPy's that an array may be turned into; objects are pickled."""


def changed(draws: Draws, name: str, data: bytes) -> tuple[bytes, str]:
    """The content of a file with one change, and what was changed.

    Args:
        draws: what draws.
        name: name of the file; the ending says its form.
        data: its content.
    """
    if draws.chance(0.15):
        return change_bytes(draws, data)
    return WRITERS.get(PurePath(name).suffix, change_bytes)(draws, data)


def change_bytes(draws: Draws, data: bytes) -> tuple[bytes, str]:
    """Bytes that are torn, flipped, joined, or of another encoding."""
    at = draws.integer(max(len(data), 1))
    kind = draws.pick(("torn", "flipped", "added", "cut", "empty", "zeros", "twice", "BOM", "UTF-16", "text"))
    if kind == "flipped" and data:
        return data[:at] + bytes([data[at] ^ (1 << draws.integer(8))]) + data[at + 1 :], f"bit flipped at {at}"
    junk = draws.pick((b"\0", b"\xff", b"\r", b"\n", b'"', b"\xc3", b"\xe2\x80\xae", b"PK\x03\x04", b"\t", bytes(4096)))
    several = draws.integer(1, 40)
    contents = {
        "torn": data[:at], "added": data[:at] + junk + data[at:], "cut": data[:at] + data[at + several :], "empty": b"",
        "zeros": bytes(len(data)), "twice": data + data, "BOM": b"\xef\xbb\xbf" + data,
        "UTF-16": data.decode("latin-1").encode("utf-16"), "text": b"text",
    }  # fmt: skip
    return contents.get(kind, data), f"{kind} at {at}"


def change_json(draws: Draws, data: bytes) -> tuple[bytes, str]:
    """A JSON document with one change."""
    return change_document(draws, json.loads(data), JSON_VALUES, json.dumps)


def change_yaml(draws: Draws, data: bytes) -> tuple[bytes, str]:
    """A YAML document with one change."""
    return change_document(draws, parsed_yaml(data.decode(), PlainLoader), YAML_VALUES, yaml_text)


def change_document(
    draws: Draws, document: Any, values: tuple[str, ...], write: Callable[[Any], str]
) -> tuple[bytes, str]:
    """A document with one change, as text: a value, or a key."""
    places = list(places_of(document))
    if not places:
        return draws.pick(values).encode(), "the whole"
    place, new = draws.pick(places), deepcopy(document)
    parent: Any = reduce(getitem, place[:-1], new)
    key, old = place[-1], parent[place[-1]]
    text, how = draws.pick(values), draws.pick(("value", "value", "value", "number", "gone", "again", "key"))
    if how == "gone":
        del parent[key]
    elif how == "again" and isinstance(parent, list):
        parent += [deepcopy(old)] * draws.pick((1, 2, 300))
    elif how in ("again", "key") and isinstance(parent, dict):
        parent[MARK] = deepcopy(old)
        text = json.dumps(str(key) if how == "again" else draws.pick(KEYS))
        if how == "key" and draws.chance(0.5):
            del parent[key]
    else:
        parent[key] = MARK
        if how == "number" and isinstance(old, int | float) and not isinstance(old, bool):
            text = repr(float(old) * draws.pick(FACTORS)).replace("inf", "1e999")
    written = re.sub(f"\"{MARK}\"|'{MARK}'|{MARK}", lambda _: text, write(new))
    return written.encode("utf-8", "surrogatepass"), f"{how} at {'.'.join(map(str, place))}: {text[:40]}"


def places_of(document: Any, begin: Place = ()) -> Iterator[Place]:
    """Places of all values in a document."""
    keys = document if isinstance(document, dict) else range(len(document)) if isinstance(document, list) else ()
    for key in keys:
        yield (*begin, key)
        yield from places_of(document[key], (*begin, key))


def change_table(draws: Draws, data: bytes) -> tuple[bytes, str]:
    """A CSV table with one change: a cell, a column, a row, or a name of a column."""
    header, *rows = list(csv.reader(io.StringIO(data.decode())))
    column, row = draws.integer(len(header)), draws.integer(len(rows))
    how = draws.pick(("cell", "cell", "cell", "factor", "unit", "shift", "column", "row", "name", "ends"))
    said = f"{how} of {header[column]!r}, row {row + 1}"
    if how == "ends":
        end, mark = draws.pick((("\r\n", ","), ("\r", ","), ("\n\n", ","), ("\n", ";"), ("\n", "\t"), ("\v", ",")))
        return end.join(mark.join(line) for line in [header, *rows]).encode(), said
    if how == "name":
        header[column] = draws.pick(("", "typo", " item ", header[column - 1], header[column].upper(), "x" * 300, '"'))
    elif how == "row":
        rows[row] = draws.pick((rows[row][:-1], [*rows[row], "1"], [], rows[row] * 20, ["x"], rows[row - 1]))
    elif how == "column":
        cell = draws.pick((*CELLS, "", None))
        rows = [line[:column] + ([] if cell is None else [cell]) + line[column + 1 :] for line in rows]
        header = header[:column] + header[column + 1 :] if cell is None else header
        said += f" {str(cell)[:30]!r}"
    else:
        by = draws.pick(FACTORS)
        for line in [rows[row]] if how in ("cell", "factor") else rows:
            line[column] = draws.pick(CELLS) if how == "cell" else _other(line[column], by, how)
        said += f" {rows[row][column][:30]!r}"
    return "\n".join(",".join(line) for line in [header, *rows]).encode("utf-8", "surrogatepass"), said


def _other(cell: str, by: float, how: str) -> str:
    """A cell whose number is another; a shift adds to it, and all else is a factor."""
    try:
        value = float(cell)
    except ValueError:
        return cell
    with np.errstate(over="ignore"):
        return repr(float(np.float64(value) + by if how == "shift" else np.float64(value) * by))


def change_archive(draws: Draws, data: bytes) -> tuple[bytes, str]:
    """A zip archive with one change in one of its parts, or with other parts."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        parts = [(name, archive.read(name)) for name in archive.namelist()]
    at = draws.integer(len(parts))
    name, content = parts[at]
    how = draws.pick(("part", "part", "part", "part", "gone", "twice", "name", "more", "swapped"))
    said = f"{how} {name}"
    if how == "part":
        form = ".json" if content[:1] == b"{" else PurePath(name).suffix
        content, words = changed(draws, f"x{form}", content)
        parts[at], said = (name, content), f"{said}: {words}"
    elif how == "gone":
        del parts[at]
    elif how == "swapped":
        other = draws.integer(len(parts))
        parts[at], parts[other] = (name, parts[other][1]), (parts[other][0], content)
    else:
        names = (
            "../x.npy",
            "/x.npy",
            "x.pkl",
            "weight_99.npy",
            "weight_1000.npy",
            "x" * 300,
            "a/b.npy",
            "x.npy",
            "\u202ex.npy",
        )
        new = name if how == "twice" else draws.pick(names)
        parts = [*parts, (new, content)] if how != "name" else [*parts[:at], (new, content), *parts[at + 1 :]]
        said += f" as {new[:30]}"
    written = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(written, "w", draws.pick((0, 8, 12))) as archive:
        warnings.simplefilter("ignore")  # of a name that stands twice
        for part, inside in parts:
            archive.writestr(part, inside)
    return written.getvalue(), said


def change_array(draws: Draws, data: bytes) -> tuple[bytes, str]:
    """An array of NumPy's with another type, shape or value, or with a header that lies."""
    array: Any = np.load(io.BytesIO(data), allow_pickle=False)
    how = draws.pick(("value", "value", "type", "shape", "header", "text"))
    if how == "header":
        false = draws.pick((b"(1,)", b"(99999999999,)", b"(-1,)", b"()", b"(2**70,)", b"x", b"(True,)"))
        return data[:128].replace(str(array.shape).encode(), false) + data[128:], f"{how} {false.decode()}"
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        new, said = ARRAYS[how](draws, array)
    written = io.BytesIO()
    np.save(written, new, allow_pickle=True)
    return written.getvalue(), f"{how} {said}"


def _value(draws: Draws, array: Any) -> tuple[Any, str]:
    """The array with another value somewhere, or everywhere."""
    if array.dtype.kind not in "fiub" or not array.size:
        word = draws.pick(("", "x", "x" * 500, "Tanh", "scores", "clipped", "nan", "\u202e"))
        return np.array(word), word[:20]
    value = draws.pick((np.nan, np.inf, -np.inf, 0.0, -1.0, 1e30, -1e38, 1e-45, 0.5, 255.0, 1e5, 2.0**31))
    flat = array.copy().reshape(-1)
    flat[slice(None) if draws.chance(0.3) else draws.integer(flat.size)] = np.array(value).astype(array.dtype)
    return flat.reshape(array.shape), str(value)


def _type(draws: Draws, array: Any) -> tuple[Any, str]:
    kind = draws.pick(KINDS)
    try:
        return array.astype(kind), kind
    except (ValueError, TypeError):
        return np.zeros(array.shape, kind), kind


def _shape(draws: Draws, array: Any) -> tuple[Any, str]:
    """The array with other axes."""
    flat, twice = np.resize(array, (max(array.size, 1),)), np.resize(array, (2 * max(array.size, 1),))
    shapes: tuple[Any, ...] = (
        flat, array[None], array[..., None], array.T, flat[:0], flat[:1], flat[0], twice, flat[:-1], flat[:0, None],
        *((array[:-1], array[..., :-1], np.concatenate([array, array])) if array.ndim else ()),
        np.resize(flat, (*array.shape, 7)),
    )  # fmt: skip
    new = draws.pick(shapes)
    return new, str(new.shape)


def _text(draws: Draws, array: Any) -> tuple[Any, str]:
    words = draws.pick(("x", "Tanh", "ReLU", "scores", "squashed", "", "x" * 500))
    return np.array(words if array.ndim == 0 else [words]), words[:20]


ARRAYS: Final[dict[str, Callable[[Draws, Any], tuple[Any, str]]]] = {
    "value": _value, "type": _type, "shape": _shape, "text": _text,
}  # fmt: skip
WRITERS: Final[dict[str, Callable[[Draws, bytes], tuple[bytes, str]]]] = {
    ".json": change_json, ".yaml": change_yaml, ".yml": change_yaml, ".csv": change_table, ".npz": change_archive,
    ".zip": change_archive, ".npy": change_array,
}  # fmt: skip
"""What changes a file, by its ending; bytes of all others are changed."""
