"""Files of strangers are data of a bounded size, and YAML means the same to every reader."""

import ast
import json
import os
import re
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.reading import (
    AccessError,
    ReadError,
    arrays_of,
    json_of,
    lines_of,
    parsed_yaml,
    text_of,
    yaml_of,
    yaml_text,
)
from pnt_gym.reading.archives import MOST_PARTS
from pnt_gym.reading.files import LONGEST_LINE
from pnt_gym.reading.plain_yaml import MOST_NODES

ROOT = Path(__file__).resolve().parents[1]
NUMBERS = {
    "010": 10, "-7": -7, "+5": 5, "1_000": 1000, "1e-3": 0.001, "1e5": 100000.0, ".5": 0.5, "5.": 5.0, "-.5e+2": -50.0,
    "!!float 1e5": 100000.0, "!!int 010": 10, ".inf": np.inf, "-.Inf": -np.inf,
}  # fmt: skip
TEXTS = ("1:30", "on", "off", "No", "0x1F", "0o17", "0b11", "2020-01-01", "1,5", "1 0", "e5", "--1", "1e", "_1", "'7'")


@pytest.mark.parametrize("text", NUMBERS)
def test_numbers_are_decimal(text):
    (value,) = parsed_yaml(f"[{text}]")
    assert (value, type(value)) == (NUMBERS[text], type(NUMBERS[text]))


@pytest.mark.parametrize("text", TEXTS)
def test_all_else_is_text(text):
    assert parsed_yaml(f"a: {text}") == {"a": text.strip("'")}


@pytest.mark.parametrize("text", ["!!float 1:30", "!!int 0x1F", "!!int 1.5", "!!float abc"])
def test_a_tag_makes_no_number_of_other_text(text):
    with pytest.raises(ReadError, match="no decimal"):
        parsed_yaml(f"a: {text}")


@pytest.mark.parametrize(
    ("text", "key", "line"),
    [
        ("belt: {speed: 0.3, speed: 0.4}", "speed", 1),
        ("belt:\n  speed: 1\nbins: 2\nbelt:\n  x: 1", "belt", 4),
        ("- {a: 1}\n- {a: 1, 'a': 2}", "a", 2),
        ("1: a\n01: b", "01", 2),
        ("1: a\n1.0: b", "1.0", 2),
        ("b: &b {x: 1}\na: {<<: *b, <<: *b}", "<<", 2),
    ],
)
def test_a_key_that_stands_twice_is_refused_by_name_and_line(text, key, line):
    with pytest.raises(ReadError, match=rf"key '{key}' is given twice: line {line} "):
        parsed_yaml(text)


def test_merged_keys_may_be_given_anew():
    data = parsed_yaml("a: &a {x: 1, y: 2}\nb: &b {<<: *a, x: 3}\nc: {<<: [*b, *a], z: 4}")
    assert data["b"] == {"x": 3, "y": 2}
    long = parsed_yaml("a: &a {speed: 1}\nb: &b {<<: *a, speed: 2}\nc: {<<: [*a, *b]}\nd: {<<: [*b, *a]}")
    assert (long["c"], long["d"]) == ({"speed": 1}, {"speed": 2})
    with pytest.raises(ReadError, match="<< merges mappings"):
        parsed_yaml("a: {<<: [1]}")
    assert data["c"] == {"x": 3, "y": 2, "z": 4}


PLAIN = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(allow_nan=False), st.text(), st.sampled_from(TEXTS)
)


@given(st.dictionaries(st.text(), st.one_of(PLAIN, st.lists(PLAIN), st.sampled_from(sorted(NUMBERS)))))
def test_what_is_written_is_read_as_it_was_here_and_by_others(data):
    text = yaml_text(data)
    assert parsed_yaml(text) == data
    assert yaml.safe_load(text) == data


def bomb(levels: int) -> str:
    """Aliases that repeat ten times what stands before them."""
    lines = ["a0: &a0 [0]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, levels + 1)]
    return "\n".join(lines)


@pytest.mark.parametrize("text", [bomb(6), "a: &a [*a]", "[" * 20_000, "{a: " * 5000, "- !!python/name:os.system x"])
def test_yaml_that_would_take_memory_or_run_something_is_refused(text):
    with pytest.raises(ReadError) as caught:
        parsed_yaml(text)
    assert len(str(caught.value)) < 200


def test_aliases_may_repeat_something():
    assert parsed_yaml(bomb(3))["a3"][0][0][0] == [0]
    assert 10**3 < MOST_NODES < 10**6


def test_an_error_repeats_nothing_of_the_file():
    for text in ("root:x:0:0: [secret", "a: b: secret", "\tsecret"):
        with pytest.raises(ReadError) as caught:
            parsed_yaml(text)
        assert "secret" not in str(caught.value)


READERS = {
    "text": text_of, "json": json_of, "yaml": yaml_of, "npz": lambda path: arrays_of(path, ANY),
    "lines": lambda path: list(lines_of(path, 1000, 10)),
}  # fmt: skip


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("kind", ["/dev/zero", "/dev/stdin", "fifo", "folder", "link", "large", "none", "nul"])
def test_what_is_no_file_of_a_bounded_size_is_not_read(reader, kind, tmp_path: Path):
    path = tmp_path / kind if "/" not in kind else Path(kind)
    if kind == "fifo":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "link":
        path.symlink_to("/dev/zero")
    elif kind == "large":
        with path.open("wb") as file:
            file.truncate(2**40)  # of which the disk holds nothing
    elif kind == "nul":
        path = Path("a\0b")
    with pytest.raises(AccessError):
        READERS[reader](path)


ANY = re.compile(r"\w+")


@pytest.mark.parametrize("reader", READERS)
def test_a_file_that_cannot_be_read_on_is_refused(reader):
    with pytest.raises(ReadError):
        READERS[reader](Path("/proc/self/mem"))


def archive_of(path: Path, parts: dict[str, bytes], compress: bool = True) -> Path:
    kind = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
    with zipfile.ZipFile(path, "w", kind) as file:
        for name, content in parts.items():
            file.writestr(name, content)
    return path


def header(shape: str, kind: str = "<f8") -> bytes:
    """The beginning of an array's file."""
    text = f"{{'descr': {kind!r}, 'fortran_order': False, 'shape': {shape}, }}".encode()
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text


def test_arrays_are_read_as_numpy_has_written_them(tmp_path: Path):
    arrays = {"a": np.arange(6.0).reshape(2, 3), "b": np.array("name"), "c": np.zeros((0, 4), np.float32)}
    np.savez(tmp_path / "a.npz", **arrays)
    read = arrays_of(tmp_path / "a.npz", ANY)
    assert [*read] == [*arrays]
    assert all(read[name].dtype == array.dtype and np.array_equal(read[name], array) for name, array in arrays.items())


MANY = {f"a{k}.npy": header("()") + bytes(8) for k in range(MOST_PARTS + 1)}


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"a.npy": header("(16777216,)") + bytes(2**27)}, "bytes; at most"),
        ({f"a{k}.npy": header("(1048576,)") + bytes(2**23) for k in range(9)}, "bytes; at most"),
        (MANY, "parts; at most"),
        ({"a.npy": header("(1000000000000,)") + bytes(8)}, "do not fit together"),
        ({"a.npy": header("(-1,)") + bytes(8)}, "do not fit together"),
        ({"a.npy": header("(1,)", "|O") + bytes(8)}, "do not fit together"),
        ({"a.npy": header("(__import__('os').getpid(),)") + bytes(8)}, "no archive that can be read"),
        ({"../a.npy": header("()") + bytes(8)}, "does not belong there"),
        ({"a.pkl": b"x"}, "does not belong there"),
        ({"a.npy": b"nothing"}, "no archive that can be read"),
    ],
)
def test_an_archive_that_promises_too_much_is_refused_before_it_is_unpacked(parts, said, tmp_path: Path):
    with pytest.raises(ReadError, match=said):
        arrays_of(archive_of(tmp_path / "a.npz", parts), ANY)


def test_a_damaged_part_by_lzma_is_refused(tmp_path: Path):
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_LZMA) as file:
        file.writestr("a.npy", header("(1024,)") + np.random.default_rng(0).bytes(2**13))
    data = bytearray((tmp_path / "a.npz").read_bytes())
    data[40:4000] = bytes(3960)
    (tmp_path / "a.npz").write_bytes(data)
    with pytest.raises(ReadError, match="no archive that can be read"):
        arrays_of(tmp_path / "a.npz", ANY)


def test_a_size_that_an_archive_lies_about_is_not_trusted(tmp_path: Path):
    path = archive_of(tmp_path / "a.npz", {"a.npy": header("(1048576,)") + bytes(2**23)})
    data = path.read_bytes()
    true, told = (struct.pack("<I", size) for size in (2**23 + 128, 128 + 8))
    path.write_bytes(data.replace(true, told))
    with pytest.raises(ReadError):
        arrays_of(path, ANY)


def test_lines_come_one_by_one_and_are_bounded(tmp_path: Path):
    path = tmp_path / "a.csv"
    path.write_bytes(b"\xef\xbb\xbfa\r\n\xc3\xa4\rc\n\nd")
    assert list(lines_of(path, 100, 5)) == ["a\r\n", "ä\r", "c\n", "\n", "d"]
    for most, most_lines, said in ((100, 4, "more than 4 lines"), (5, 5, "at most 5 are read")):
        with pytest.raises(AccessError, match=said):
            list(lines_of(path, most, most_lines))
    path.write_text("a\n" + "b" * (LONGEST_LINE + 1))
    lines = lines_of(path, 2**20, 5)
    assert next(lines) == "a\n"
    with pytest.raises(AccessError, match="its line 2 has more than 65,536 characters"):
        next(lines)
    path.write_bytes(b"a\n\xff")
    with pytest.raises(ReadError, match="it must be UTF-8"):
        list(lines_of(path, 100, 5))


SPARED = {"sb3.py": "a model is read for who says --trust", "archives.py": "archives are written alone"}
"""Files of the code in which a library may read by itself."""


OPENERS = ("Image.open(io.BytesIO(", "os.open(", "parts.open(", "webbrowser.open(")
"""Calls that open no file for reading, or a part of an archive that is open already."""
PARSERS = {"yaml.load", "yaml.safe_load", "np.load", "json.load", "ZipFile", "zipfile.ZipFile", "torch.load"}


@pytest.mark.parametrize("room", ["agents", "papers", "pnt_gym"])
def test_no_other_code_parses_a_file(room):
    for file in ROOT.glob(f"{room}/**/*.py"):
        text = file.read_text()
        if file.parent.name != "reading" and file.name not in SPARED and any(name in text for name in PARSERS):
            calls = {ast.unparse(node.func) for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)}
            assert not PARSERS & calls, file


@pytest.mark.parametrize("room", ["agents", "papers", "pnt_gym"])
def test_no_other_code_opens_a_file_to_read_it(room):
    """A file may be a pipe or a device, which `open` waits for or reads without an end."""
    for file in ROOT.glob(f"{room}/**/*.py"):
        if file.parent.name == "reading" or "open(" not in file.read_text():
            continue
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] == "open":
                words = ast.unparse(node)
                assert "'wb'" in words or words.startswith(OPENERS), f"{file}: {words}"


def test_json_of_a_file_is_the_data_with_every_key_once(tmp_path: Path):
    data = {"a": [1, 2.5, None, {"b": "ä"}]}
    (tmp_path / "a.json").write_text(json.dumps(data), encoding="utf-8")
    assert json_of(tmp_path / "a.json") == data
    (tmp_path / "deep.json").write_text("[" * 100_000)
    with pytest.raises(ReadError, match="too deep"):
        json_of(tmp_path / "deep.json")
    (tmp_path / "twice.json").write_text('{"a": {"b": 1, "b": 2}}')
    with pytest.raises(ReadError, match="key 'b' is given twice"):
        json_of(tmp_path / "twice.json")
