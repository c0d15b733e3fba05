"""What the house promises of its code, read from the code itself."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import grimp

import pnt_gym

PACKAGE = Path(pnt_gym.__file__).parent
AGENTS = PACKAGE.parent / "agents"
CELLS = {"conveyor", "one_joint", "gripper", "line"}


def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def classes() -> Iterator[tuple[str, Path]]:
    """Every class of the package at the top of a module, with its file."""
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in _tree(path).body:
            if isinstance(node, ast.ClassDef):
                yield node.name, path.relative_to(PACKAGE)


def test_a_class_has_a_name_of_its_own_but_for_pairs_across_the_cells():
    """The cells' folders have one shape, so what plays the same part there may bear the same name."""
    places = defaultdict(list)
    for name, path in classes():
        places[name].append(path)
    assert len(places) > 100
    for name, paths in places.items():
        rooms = [path.parts[1] for path in paths if path.parts[0] == "cells"]
        across = len(rooms) == len(paths) and set(rooms) <= CELLS and len(set(rooms)) == len(rooms)
        assert len(paths) == 1 or across, f"{name} stands in {', '.join(map(str, paths))}"


def files() -> list[Path]:
    """Every module of the suite and of its agents."""
    return [path for room in (PACKAGE, AGENTS) for path in sorted(room.rglob("*.py"))]


def functions(path: Path) -> list[ast.FunctionDef | ast.AsyncFunctionDef]:
    """Every function of a module, with methods and functions inside functions."""
    return [node for node in ast.walk(_tree(path)) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]


def line_count(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


def test_functions_take_few_arguments():
    """No function of the suite and of its agents has more than eight."""
    found = [(path, node) for path in files() for node in functions(path)]
    assert len(found) > 4000
    for path, node in found:
        names = [part.arg for part in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]]
        assert len([name for name in names if name not in ("self", "cls")]) <= 8, f"{node.name} in {path}"


def test_functions_that_do_the_same_have_the_same_name():
    """A reader learns at most 32 names of functions in a thousand lines."""
    names = {node.name for path in files() for node in functions(path)}
    assert len(names) / sum(map(line_count, files())) <= 0.032


def test_few_files_of_the_agents_are_short():
    """An idea stands in one file: at most a quarter have fewer than a hundred lines."""
    lines = [line_count(path) for path in sorted(AGENTS.rglob("*.py"))]
    assert sum(count < 100 for count in lines) / len(lines) <= 0.25


def test_compiled_files_compute_more_than_they_declare():
    """Signatures and descriptions of arguments are at most a quarter of the files with compiled functions."""
    compiled = [path for path in files() if "@kernel" in path.read_text(encoding="utf-8")]
    declared = 0
    for node in [node for path in compiled for node in functions(path)]:
        declared += node.body[0].lineno - node.lineno
        described = (ast.get_docstring(node) or "").partition("Args:\n")[2]
        declared += len(described.partition("Returns:")[0].rstrip().splitlines())
    assert len(compiled) > 30
    assert declared / sum(map(line_count, compiled)) <= 0.25


def test_planning_reads_fields_by_name():
    """No constants of a module number columns (`X, Y = range(2)`)."""
    for path in sorted(PACKAGE.glob("planning/**/*.py")):
        for node in ast.walk(_tree(path)):
            is_many = isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple)
            assert not (is_many and ast.unparse(node.value).startswith("range(")), f"{ast.unparse(node)} in {path}"


def test_no_modules_of_agents_import_each_other_in_a_circle():
    """Imports inside functions count, too."""
    graph = grimp.build_graph("agents", cache_dir=None)
    left = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert len(left) > 100
    while free := [module for module, needed in left.items() if not needed & left.keys()]:
        for module in free:
            del left[module]
    assert not left
