"""`python -m agents.publish`: the copy of a policy can be used, and its card tells what it is worth."""

import json
import shutil
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import onnxruntime
import pytest
import yaml

from agents.ground.cli import UsageError
from agents.judging.evaluation import evaluate
from agents.learning.runs import RunFolder
from agents.publish import __main__ as publish
from agents.publish import folder
from agents.publish.__main__ import Arguments
from tests.tools.commands import answered, figures_of, output_of, refused

NAME = "OneJointThrow-v0-ideal-sac-seed0"


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("trained")
    output_of("train --env OneJointThrow-v0 --level ideal --steps 32 --eval-picks 0 --out run", place)
    return place / "run"


@pytest.fixture
def run(trained: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(trained, tmp_path / "run"))


def metadata(card: str) -> dict[str, Any]:
    return yaml.safe_load(card.split("---\n")[1])


def test_a_published_policy_throws_as_the_run_did(run: Path, tmp_path: Path) -> None:
    command = ("agents.publish", run, "--to", tmp_path / "kept", "--picks", "16", "--no-video")
    assert answered(*command)[0] == 0
    (copy,) = (tmp_path / "kept").iterdir()
    lies = {path.name for path in copy.iterdir()}
    assert copy.name == NAME
    assert lies - {"git.txt"} == {*folder.FILES, "README.md", "policy.onnx", "curve.png"} - {"git.txt"}
    found = [figures_of(f"evaluate --controller {place} --picks 16", tmp_path) for place in (run, copy)]
    assert found[0] | {"controller": ""} == found[1] | {"controller": ""}
    card = (copy / "README.md").read_text()
    assert f"| ideal | {1000 * found[0]['landing_error_mean_m']:.1f} mm |" in card
    assert f"--controller {copy.name} " in card
    assert "replay.mp4" not in card
    (result,) = metadata(card)["model-index"][0]["results"]
    told = {metric["type"]: metric["value"] for metric in result["metrics"]}
    assert told["landing_error_mean_m"] == round(found[0]["landing_error_mean_m"], 4)
    reward = np.array([throw["reward"] for throw in found[0]["throws"]])
    assert told["mean_reward"] == f"{reward.mean():.2f} +/- {reward.std():.2f}"
    session, actor = onnxruntime.InferenceSession(copy / "policy.onnx"), RunFolder(copy).actor()
    seen = np.random.default_rng(1).standard_normal((9, actor.sizes[0])).astype(np.float32)
    np.testing.assert_allclose(session.run(["action"], {"observation": seen})[0], actor(seen), rtol=0, atol=1e-6)
    about = session.get_modelmeta().custom_metadata_map
    assert (about["env"], about["action_mode"]) == ("OneJointThrow-v0", RunFolder(run).arguments["action_mode"])
    assert "exists already" in refused(*command)


@pytest.mark.nightly
@pytest.mark.usefixtures("opengl")
def test_the_film_shows_throws_of_the_policy(run: Path, tmp_path: Path) -> None:
    output_of(f"publish {run} --to kept --picks 4 --no-onnx", tmp_path)
    copy = tmp_path / "kept" / NAME
    frames = iio.imread(copy / "replay.mp4")
    assert frames.shape[1:] == (368, 640, 3)
    assert 5 * 0.4 * 30 <= len(frames) <= 5 * 0.7 * 30
    assert np.abs(frames[0].astype(int) - frames[len(frames) // 2]).max() > 40
    card = (copy / "README.md").read_text()
    assert "(replay.mp4)" in card
    assert "onnx" not in card
    assert not (copy / "policy.onnx").exists()


FULL_DISK = OSError(28, "No space left on device")


@pytest.mark.parametrize(
    ("part", "error"),
    [
        ("save", FULL_DISK),
        ("film", KeyboardInterrupt()),
        ("evaluate", KeyboardInterrupt()),
        ("write_text", FULL_DISK),
    ],
)
def test_a_folder_is_published_in_full_or_not_at_all(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, part: str, error: BaseException
) -> None:
    def fails(*_: Any, **__: Any) -> None:
        raise error

    kept = tmp_path / "kept"
    asked = Arguments(run, to=kept, picks=4, video=part == "film")
    with monkeypatch.context() as patch:
        places = (folder, publish, folder.onnx_graph)
        patch.setattr(next(place for place in places if hasattr(place, part)), part, fails)
        with pytest.raises(type(error)):
            publish.main(asked)
    assert not kept.exists()
    publish.main(Arguments(run, to=kept, picks=4, video=False))
    assert [path.name for path in kept.iterdir()] == [NAME]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"algo": "recurrent_ppo"}, "a policy of recurrent_ppo has a memory, which policy.onnx cannot hold"),
        ({"over": "static"}, "policy.onnx would lack the controller 'static' under the policy"),
    ],
)
def test_a_graph_that_is_not_the_whole_policy_is_not_written(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: dict[str, str], said: str
) -> None:
    monkeypatch.setattr(publish, "check_model", lambda _, is_copied: None)
    RunFolder(run).write({**RunFolder(run).arguments, **changes})
    with pytest.raises(UsageError, match=f"{said}; give --no-onnx"):
        publish.main(Arguments(run, to=tmp_path / "kept", picks=4, video=False))
    assert not (tmp_path / "kept").exists()


def test_a_policy_with_a_memory_is_published_without_its_graph(tmp_path: Path) -> None:
    level = {"name": "brief", "base": "day", "fidelity": "flight", "picks_per_shift": 5}
    (tmp_path / "brief.yaml").write_text(yaml.safe_dump(level))
    what = "--env PnTAdapt-v0 --level brief.yaml --algo recurrent_ppo --over ema"
    output_of(f"train {what} --num-envs 2 --steps 4 --eval-picks 0 --out run", tmp_path)
    publish.main(Arguments(tmp_path / "run", to=tmp_path / "kept", picks=8, video=False, onnx=False, model=False))
    (copy,) = (tmp_path / "kept").iterdir()
    assert not (copy / "model.zip").exists() and "model.zip" not in (copy / "README.md").read_text()
    assert "Its action is added to that of `ema`." in (copy / "README.md").read_text()
    figures = [evaluate(str(folder), "PnTAdapt-v0", 8, level=level) for folder in (tmp_path / "run", copy)]
    assert figures[0] | {"controller": ""} == figures[1] | {"controller": ""}


@pytest.mark.parametrize("text", [None, "", "throws\n", "throws,seconds\n1,2\n", "a,b,c,d,e\n1,2,3,4,x\n"])
def test_a_training_without_its_figures_is_damaged(run: Path, tmp_path: Path, text: str | None) -> None:
    (run / "progress.csv").unlink()
    if text is not None:
        (run / "progress.csv").write_text(text)
    assert "is damaged: progress.csv is missing or torn" in refused("agents.publish", run, "--to", tmp_path / "kept")
    assert not (tmp_path / "kept").exists()


def test_a_published_policy_can_be_published_again(run: Path, tmp_path: Path) -> None:
    publish.main(Arguments(run, to=tmp_path / "one", picks=8, video=False))
    publish.main(Arguments(tmp_path / "one" / NAME, to=tmp_path / "other", picks=8, video=False))
    one, other = ({p.name: p.read_bytes() for p in (tmp_path / name / NAME).iterdir()} for name in ("one", "other"))
    assert one == other
    assert json.loads(one["versions.json"])["python"]
