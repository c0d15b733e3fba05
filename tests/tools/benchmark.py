"""Plans of small benchmarks on the cell on paper, and what the benchmark's file holds of a plan."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from agents.benchmark.run import run_piece
from agents.ground.files import json_text
from agents.ground.versions import versions
from agents.results import content
from agents.results.compare import assemble
from agents.results.plan import Plan, pieces
from tests.tools.commands import answered

FILE = Path("file.json")
"""The result that a test verifies, in the working folder."""


def toy_plan(*entries: Mapping[str, Any], **more: Any) -> dict[str, Any]:
    """A plan of some entries, by default of the planner alone, on a level."""
    usual = {"name": "small", "env": "ToyThrow-v0", "train_level": "waste", "levels": ["waste"], "picks": 24}
    return {**usual, "num_envs": 8, "entries": [*entries] or [{"label": "a", "controller": "analytic"}], **more}


def carried_out(content: Mapping[str, Any], work: Path) -> dict[str, Any]:
    """The result of a plan whose pieces are done in this process, and under `policies` the stored ones by file."""
    plan = Plan.model_validate(content)
    parts = [run_piece(piece, work) for piece in pieces(plan)]
    results = [row for part in parts for row in part.results]
    head = {"plan": plan.model_dump(mode="json"), "versions": versions(), "seconds": 1.0}
    policies = {name: policy for part in parts for name, policy in part.policies.items()}
    return {**json.loads(json_text({**head, **assemble(plan, results), "results": results})), "policies": policies}


def write(path: Path, data: Mapping[str, Any]) -> None:
    """Write a result and its policies, as a command does."""
    head = {name: value for name, value in data.items() if name not in ("decimals", "results", "policies")}
    content.write(path, head, data["results"], data.get("policies", {}))


def forge(data: dict[str, Any]) -> None:
    """Let a result show what its changed throws give."""
    data |= json.loads(json_text(assemble(Plan.model_validate(data["plan"]), data["results"])))


def verify(data: Any, *options: str) -> tuple[int, list[dict[str, Any]]]:
    """Exit code and verdicts of the command about a result."""
    write(FILE, data)
    return verified(*options)


def verified(*options: str) -> tuple[int, list[dict[str, Any]]]:
    """Exit code and verdicts of the command about the file."""
    code, words = answered("agents.benchmark.verify", FILE, "--json", "out.json", *options)
    assert code in (0, 1, 3), words
    return code, json.loads(Path("out.json").read_text())["verdicts"]
