"""What the package is made of and what its workflows may do, read from the files themselves."""

import json
import re
import runpy
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
import yaml
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
EXTRAS = PROJECT["project"]["optional-dependencies"]
SBOM = runpy.run_path(str(ROOT / ".ci" / "sbom.py"))
PINS = {pin.name: pin for pin in SBOM["pins"]((ROOT / "constraints.txt").read_text(encoding="utf-8"))}
BILL = json.loads((ROOT / "sbom.cdx.json").read_text(encoding="utf-8"))
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PINNED = re.compile(r"[\w.-]+/[\w./-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+")


def steps(workflow):
    return [step for job in workflow["jobs"].values() for step in job["steps"]]


def faults(text):
    """What is wrong with a workflow: rights to write outside of the job that publishes, moving actions, kept tokens."""
    workflow = yaml.safe_load(text)
    wrong = [] if workflow.get("permissions") == {"contents": "read"} else ["rights"]
    for job in workflow["jobs"].values():
        publishes = [step for step in job["steps"] if step.get("uses", "").startswith("actions/deploy-pages@")]
        least = {"pages": "write", "id-token": "write"} if publishes and len(job["steps"]) == 1 else None
        wrong += [] if job.get("permissions") in (None, least) else ["rights of a job"]
    wrong += [uses for uses in re.findall(r"uses: *(.*)", text) if not PINNED.fullmatch(uses)]
    checkouts = [step for step in steps(workflow) if step.get("uses", "").startswith("actions/checkout@")]
    wrong += ["token" for step in checkouts if step.get("with", {}).get("persist-credentials") is not False]
    return wrong


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_a_workflow_has_the_least_rights_and_actions_that_stay_as_they_are(path):
    assert faults(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("permissions:\n  contents: read\n", ""),
        ("  contents: read\n", "  contents: write\n"),
        ("permissions:\n  contents: read\n", "permissions: write-all\n"),
        ("  build:\n", "  build:\n    permissions: {contents: write}\n"),
        ("      - uses: actions/deploy-pages", "      - run: make docs\n      - uses: actions/deploy-pages"),
        ("3d3c42e5aac5ba805825da76410c181273ba90b1 # v7.0.1", "v7"),
        ("3d3c42e5aac5ba805825da76410c181273ba90b1 # v7.0.1", "3d3c42e"),
        (" # v7.0.1", ""),
        ("persist-credentials: false", "persist-credentials: true"),
        ("        with:\n          persist-credentials: false\n", ""),
    ],
)
def test_a_looser_workflow_is_noticed(old, new):
    text = (ROOT / ".github" / "workflows" / "site.yml").read_text(encoding="utf-8")
    assert old in text
    assert faults(text.replace(old, new))


def test_the_tests_and_the_wheel_are_tried_on_every_python_that_is_named():
    ci = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8"))
    line = "Programming Language :: Python :: 3."
    named = ["3." + name.removeprefix(line) for name in PROJECT["project"]["classifiers"] if name.startswith(line)]
    assert len(named) >= 3
    assert {name: job["strategy"]["matrix"]["python"] for name, job in ci["jobs"].items()} == {
        "everything": named, "wheel": named,
    }  # fmt: skip
    assert "make wheel" in [step.get("run") for step in ci["jobs"]["wheel"]["steps"]]


def test_the_bill_is_of_todays_versions():
    """Made anew, it has the same bytes: `make lock` writes it."""
    assert SBOM["FILE"].read_text(encoding="utf-8") == SBOM["text"]() == SBOM["text"]()


def test_the_bill_is_what_cyclonedx_asks_for():
    problem = JsonStrictValidator(SchemaVersion.V1_6).validate_str(SBOM["FILE"].read_text(encoding="utf-8"))
    assert problem is None


def test_the_wheel_carries_the_bill():
    assert PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["sbom-files"] == [SBOM["FILE"].name]
    assert SBOM["FILE"].name in PROJECT["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]


def test_the_wheel_carries_every_plan_of_a_benchmark():
    places = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    plans = [f"configs/{path.name}" for path in (ROOT / "configs").glob("benchmark*.yaml")]
    assert sorted(plans) == sorted(name for name in places if name.startswith("configs/benchmark"))
    assert all(places[name] == f"pnt_gym/{name}" for name in plans)


def required(lines):
    """Requirements of packages, self references aside."""
    return [line for line in map(Requirement, lines) if line.name != "pnt_gym"]


def test_every_range_admits_the_version_that_is_tested():
    tools = re.findall(r"^[^#\n]+", (ROOT / ".ci" / "tools.txt").read_text(encoding="utf-8"), flags=re.MULTILINE)
    extras = [line for extra in EXTRAS.values() for line in extra]
    lines = required([*PROJECT["project"]["dependencies"], *extras, *tools])
    assert len(lines) > 30
    for line in lines:
        assert line.specifier.contains(PINS[canonicalize_name(line.name)].version), line


def test_the_bill_has_what_the_wheel_needs_and_no_tools():
    """The oracle is what the installed packages say that they need."""
    listed = {part["name"]: part for part in BILL["components"]}
    todo = [canonicalize_name(line.name) for line in required(PROJECT["project"]["dependencies"])]
    core = set()
    while todo:
        name = todo.pop()
        if name not in core:
            core.add(name)
            needs = [Requirement(line) for line in metadata.requires(name) or ()]
            todo += [canonicalize_name(n.name) for n in needs if n.marker is None or n.marker.evaluate({"extra": ""})]
    assert core == {name for name, part in listed.items() if part["scope"] == "required"}
    assert {"torch", "ray", "onnx"} <= {name for name, part in listed.items() if part["scope"] == "optional"}
    assert not {"pytest", "ruff", "sphinx", "uv"} & set(listed)


def test_the_versions_are_of_torchs_cpu_build():
    assert "torch" in PINS
    assert not [name for name in PINS if name.startswith(("nvidia-", "cuda-", "triton"))]


def test_a_line_that_is_no_pin_is_refused():
    with pytest.raises(ValueError, match=r"line 'numpy>=2'; it must read NAME==VERSION  # via PARENT"):
        SBOM["pins"]("numpy>=2\n")
