"""What a command writes goes where its user points: through links, to streams and devices; none is replaced."""

import ast
import json
import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from agents.ground.cli import UsageError
from agents.ground.outputs import check_writable, deliver_json, deliver_text
from agents.ground.places import SHIPPED
from agents.ground.streams import destination, stream_of
from tests.tools.commands import environment
from tests.tools.nightly import with_nightly

EVALUATE = [sys.executable, "-m", "agents.evaluate", "--controller", "analytic", "--picks", "8", "--json"]


def test_a_link_stays_and_its_file_is_written(tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "disk" / "out.json").write_text("old\n")
    (tmp_path / "inner").symlink_to("disk/out.json")
    (tmp_path / "link.json").symlink_to(tmp_path / "inner")
    check_writable(tmp_path / "link.json")
    deliver_json(tmp_path / "link.json", [1])
    assert (tmp_path / "link.json").is_symlink()
    assert json.loads((tmp_path / "disk" / "out.json").read_text()) == [1]
    assert sorted(path.name for path in (tmp_path / "disk").iterdir()) == ["out.json"]


def test_a_link_to_nothing_yet_makes_the_file(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("new/out.txt")
    deliver_text(tmp_path / "link", "text")
    assert (tmp_path / "new" / "out.txt").read_text() == "text"


def test_links_in_a_circle_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(UsageError, match="cannot write"):
        check_writable(tmp_path / "a")
        deliver_text(tmp_path / "a", "text")


def test_a_pipe_gets_the_text(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    texts: list[str] = []
    reader = threading.Thread(target=lambda: texts.append((tmp_path / "pipe").read_text()))
    reader.start()
    deliver_text(tmp_path / "pipe", "text")
    reader.join(timeout=60)
    assert texts == ["text"]
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


@pytest.mark.parametrize("link", [False, True])
def test_devices_stay_devices(link: bool, tmp_path: Path) -> None:
    place = Path("/dev/null")
    if link:
        place = tmp_path / "nothing"
        place.symlink_to("/dev/null")
    check_writable(place)
    deliver_text(place, "text")
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)
    with pytest.raises(UsageError, match="No space left"):
        deliver_text(Path("/dev/full"), "text")


def test_a_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path)
    for place in (tmp_path, tmp_path / "link"):
        with pytest.raises(UsageError, match="it is a folder"):
            check_writable(place)


@pytest.mark.parametrize("path", ["-", "/dev/stdout", "/dev/stderr", "/dev/fd/1", "/proc/self/fd/2"])
def test_paths_of_open_streams_are_known(path: str, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(path)
    assert stream_of(destination(Path(path))) == (2 if path.endswith(("2", "err")) else 1)
    assert stream_of(destination(tmp_path / "link")) == (None if path == "-" else stream_of(destination(Path(path))))
    assert stream_of(tmp_path / "1") is None


@pytest.mark.parametrize("place", with_nightly(("-", "/dev/stdout", "/proc/self/fd/1"), ["-"]))
def test_standard_output_holds_the_data_and_nothing_else(place: str, tmp_path: Path) -> None:
    with (tmp_path / "out.txt").open("wb") as out:
        out.write(b"before\n")
        out.flush()
        done = subprocess.run(
            [*EVALUATE, place], cwd=tmp_path, env=environment(), stdout=out, stderr=subprocess.PIPE, check=False
        )
    assert done.returncode == 0, done.stderr
    first, data = (tmp_path / "out.txt").read_text().split("\n", 1)
    assert first == "before"
    assert len(json.loads(data)["throws"]) == 8
    assert b"sorted per minute" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["out.txt"]
    assert Path("/dev/stdout").is_symlink()


def test_no_command_writes_where_its_user_points_in_another_way() -> None:
    """Other writers replace links, which is right in run folders alone."""
    writers = {"write_text", "write_bytes", "write_json", "replace_file", "savez", "save_arrays", "rename"}
    for file in sorted((SHIPPED / "agents").rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in writers:
                shown = f"{file.name}:{node.lineno}: {ast.unparse(node)}"
                names = {ast.unparse(part) for part in ast.walk(node.args[0])} if node.args else set()
                assert not any(name.startswith("arguments.") for name in names), shown
