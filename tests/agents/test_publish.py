"""`python -m agents.publish`: the copy of a policy can be used, and its card tells what it is worth."""

from __future__ import annotations

import json
from pathlib import Path

from tests.tools.commands import call, call_here


def test_a_published_policy_throws_as_the_run_did(tmp_path: Path) -> None:
    folder, kept = tmp_path / "run", tmp_path / "policies"
    train = ("--env", "PnTRelease-v0", "--level", "ideal", "--steps", "32", "--eval-picks", "0", "--out", str(folder))
    assert call_here("agents.train", *train, folder=tmp_path).returncode == 0
    done = call("agents.publish", str(folder), "--to", str(kept), "--levels", "ideal", "--picks", "16", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    (copy,) = kept.iterdir()
    assert not (copy / "replay_buffer.pkl").exists()
    errors = []
    for controller in (folder, copy):
        out = tmp_path / f"{controller.name}.json"
        judged = call_here(
            "agents.evaluate", "--controller", str(controller), "--picks", "16", "--json", str(out), folder=tmp_path
        )
        assert judged.returncode == 0, judged.stderr
        errors.append(json.loads(out.read_text())["landing_error_mean_m"])
    assert errors[0] == errors[1]
    assert f"{1000 * errors[0]:.1f} mm" in (copy / "README.md").read_text()
    again = call_here(
        "agents.publish", str(folder), "--to", str(kept), "--levels", "ideal", "--picks", "16", folder=tmp_path
    )
    assert again.returncode == 2
    assert "exists already" in again.stderr
