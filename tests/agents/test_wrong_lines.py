"""Wrong command lines, each with how the one sentence begins that says so; exit code 2, and nothing is left behind."""

import io
import shlex
import shutil
import sys
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
import yaml

from agents.evaluate import Arguments
from agents.ground.cli import UsageError, _parse
from agents.ground.places import POLICY
from tests.tools.commands import refused

WRONG: Final = r"""
evaluate --controller "" | '.' holds neither foreign.zip nor best_model.zip
evaluate --controller analytic --picks 0 | --picks is 0; it must be at least 1
evaluate --controller analytic --seed -1 | --seed is -1; it must be at least 0
evaluate --controller analytic --num-envs 100001 | num_envs is 100001; it must be a whole number from 1 to 1000
evaluate --controller analytic --threads 1025 | threads is 1025; it must be a whole number from 1 to 1024
evaluate --controller analytic --practice -1 | --practice is -1; it must be at least 0
evaluate --controller analytic --level "" | unknown level ''; known are
evaluate --controller analytic --level waste.yaml | level file 'waste.yaml' does not exist
evaluate --controller analytic --level text.yaml | level file 'text.yaml' must hold a mapping of settings, it h
evaluate --controller analytic --level typo.yaml | level file 'typo.yaml': unknown key 'binz'
evaluate --controller analytic --level . | unknown level '.'; known are
evaluate --controller analytic --level day | level 'day' drifts, and the observations of this environment do not show
evaluate --controller kalman | controller 'kalman' needs observations of the previous landing; u
evaluate --controller analytic --env LONG | unknown environment 'x ... known are PnTConveyor-v0
evaluate --controller analytic --env CartPole-v1 --level waste | environment 'CartPole-v1' takes no level
evaluate --controller analytic --env OneJointThrow-v0 --level waste | unknown level 'waste'; known are contac
evaluate --controller analytic --json folder | cannot write 'folder': it is a folder
evaluate --controller analytic --json LONG/x.json | cannot write 'x ... File name too long
evaluate --controller analytic --shifts 2 | --shifts goes with work shifts; PnTConveyor-v0 is judged by throws
evaluate --controller analytic --video a.mp4 | --video goes with work shifts; PnTConveyor-v0 is judged by throws
evaluate --controller analytic --load x.npz | --load: controller 'analytic' learns nothing that could be s
evaluate --controller analytic --save x.npz | --save: controller 'analytic' learns nothing that could be s
evaluate --controller ridge --load none.npz | 'none.npz' does not exist
evaluate --controller ridge --load folder | 'folder' holds no saved controller: Is a directory
evaluate --controller ridge --load LONG | 'LONG' holds no saved controller: File name too long
evaluate --controller ridge --load x.npz | 'x.npz' holds no saved controller
evaluate --controller ridge --save file/x.npz | cannot write 'file/x.npz': File exists
evaluate --controller none.zip --trust | model 'none.zip' does not exist
evaluate --controller file | unknown controller 'file'; ... a run folder
evaluate --controller file.zip | 'file.zip' is not a run folder of `train`: loading it runs ... give --trust
evaluate --controller file.zip --trust | 'file.zip' is damaged: file.zip is truncated or not a model
evaluate --controller folder | 'folder' is not a run folder: it has no args.yml
evaluate --controller LONG | unknown controller 'x ... a run folder
evaluate --controller LONG.zip | cannot read or write 'x ... File name too long
evaluate --controller mlp --action-mode release_xyz | controller 'mlp' shifts the landing and needs an action of 2
evaluate --controller policy --env OneJointThrow-v0 | level file 'policy/env.yaml': unknown keys 'action.along', 'act
evaluate --controller policy --action-mode release_xyz | the policy of 'policy' takes observations (26,) and gives ac
evaluate --controller foreign | 'foreign/policy.npz' is damaged: policy.npz is truncated or holds no policy
evaluate --controller policy --level nominal.yaml | level file 'nominal.yaml': mismatch is 9: input should be le
evaluate --env PnTLine-v0 --controller nobody | unknown controller of a line 'nobody'; ... index, shipped:line/value
evaluate --controller nobody | unknown controller 'nobody'; known are ... more, MODULE:CLASS
evaluate --env PnTLine-v0 --controller atc --picks 9 | --picks goes with throws; PnTLine-v0 is judged by work shifts
evaluate --env PnTLine-v0 --controller atc --shifts 0 | --shifts is 0; it must be at least 1
evaluate --env PnTLine-v0 --controller atc --release ridge | level 'single' ... set `throws` to 'flight' or 'full'
evaluate --env PnTLine-v0 --controller atc --throws flight --release atc | release: unknown controller 'atc'
evaluate --env PnTLine-v0 --controller atc --video a.mpeg | --video is 'a.mpeg'; it must end in .mp4 or .gif
train --steps 0 | --steps is 0; it must be at least 1
train --seed -1 | --seed is -1; it must be at least 0
train --num-envs 0 | --num-envs is 0; it must be at least 1
train --threads 0 | --threads is 0; it must be at least 1
train --eval-picks -1 | --eval-picks is -1; it must be at least 0
train --env CartPole-v1 | environment 'CartPole-v1' has no core
train --env Nowhere-v0 | unknown environment 'Nowhere-v0'
train --level nowhere | unknown level 'nowhere'
train --env PnTLine-v0 --algo sac | algorithm sac does not learn from decisions of PnTLine-v0; algorithms there are
train --env PnTLine-v0 --stack 2 | --stack, --over and --fidelity go with throws
train --env PnTLine-v0 --over kalman | --stack, --over and --fidelity go with throws
train --env PnTLine-v0 --fidelity flight | --stack, --over and --fidelity go with throws
train --env ToyThrow-v0 --algo residual_ppo | algorithm residual_ppo does not learn from throws of ToyThrow-v0
train --env OneJointThrow-v0 --fidelity flight | --fidelity flight: environment 'OneJointThrow-v0' is simulated i
train --full-last 10 | --full-last goes with --fidelity flight
train --full-last -1 --fidelity flight | --full-last is -1; it must be at least 0
train --algo recurrent_ppo | algorithm 'recurrent_ppo' needs observations that mark the beginning of a shift
train --stack 101 --env PnTAdapt-v0 | stack is 101; a policy sees from 1 to 100 observations at once
train --stack 8 | a stack of 8 observations needs observations that mark the beginning of a shift; use PnTA
train --env OneJointThrow-v0 --stack 2 | a stack of 2 observations needs observations that mark the beginning of a shift
train --over mlp --env PnTAdapt-v0 | over: unknown controller that needs no practice 'mlp'; known are analytic, static
train --over static | controller 'static' needs observations of the previous landing; use --env PnTAdapt-v0
train --config other.yml | hyperparameters 'other.yml' have no entry for 'PnTConveyor-v0'; entries are PnTRelease-v0
train --config none.yml | cannot read hyperparameters 'none.yml': No such file or dire
train --config text.yaml | hyperparameters 'text.yaml' have no entry for 'PnTConveyor-v
train --out folder/full | 'folder/full' exists already; choose another --out, or conti
train --out file | 'file' exists already; choose another --out, or continue it with --resume
train --out file/run --env ToyThrow-v0 --steps 8 | cannot write run folder 'file/run': Not a directory
train --out LONG | cannot read or write 'x ... File name too long
train --resume file | run folder 'file' does not exist
train --resume folder | 'folder' is not a run folder: it has no args.yml
train --resume policy | run folder 'policy' is damaged: it has no checkpoint
train --resume policy --algo ppo | --algo cannot be changed with --resume, because the run folder holds
train --resume policy --out x | --out cannot be changed with --resume, because the run folder holds
benchmark --config none.yaml | cannot read benchmark 'none.yaml': No such file or directory
benchmark --config text.yaml | benchmark 'text.yaml': it is 'text': input should be a section, with keys name,
benchmark --config plan.yaml --jobs 0 | --jobs is 0; it must be at least 1
benchmark --config plan.yaml --out folder | cannot write 'folder': it is a folder
benchmark --config plan.yaml --work file --out o.json | cannot write 'file/piece.json': File exists
benchmark --config plan.yaml --work file/x --out o.json | cannot write 'file/x/piece.json': Not a directory
benchmark --config far_plan.yaml | benchmark 'far_plan.yaml': picks is -1111111111 ... input should be greater
benchmark --config idle_plan.yaml | benchmark 'idle_plan.yaml': unknown controller 'nobody'; known
benchmark --config stacked.yaml | benchmark 'stacked.yaml': entry 'a': `stack`, `over` and `fidelity` can be used only
benchmark --config over.yaml | benchmark 'over.yaml': entry 'a': over: unknown controller that needs no practice 'mlp'
benchmark --config nowhere.yaml | unknown level 'nowhere'; known are
reproduce nobody | unknown paper 'nobody'; known are hassan, choe, miyashita, l
reproduce hassan --only nothing | --only: unknown part 'nothing'; known are table1, free-direction, fr
reproduce hassan --figures file | cannot write 'file/drawing.svg': File exists
reproduce hassan --work file | cannot write 'file/piece.json': File exists
report --results broken | cannot read 'broken/x.json': it is not valid JSON: Expecting
report --results file | 'file' holds no results yet; `python -m agents.benchmark` makes some
report --results folder | 'folder' holds no results yet; `python -m agents.benchmark` makes some
play | give one of --video FILE.mp4, --picture FILE.png and --viewe
play --picture x.png --at inf | --at is inf s; it must be finite and not negative
play --picture x.png --at -1 | --at is -1.0 s; it must be finite and not negative
play --picture x.png --slow 0 | --slow is 0; it must be at least 1
play --picture a.mp4 --picks 10000 | --picture is 'a.mp4'; it must end in .png
play --video a.mp4 --picture x.png | give one of --video FILE.mp4, --picture FILE.png and --viewe
play --video a.mpeg --picks 10000 | --video is 'a.mpeg'; it must end in .mp4 or .gif
play --picture x.png --picks 2 | --picks goes with --video, and has no effect here
play --picture x.png --slow 2 | --slow goes with --video, and has no effect here
play --video a.mp4 --at 0.2 | --at goes with --picture, and has no effect here
dataset --expert oracle --practice 5 | --practice has no effect: oracle and random learn nothing that could be sent to
dataset --controller expert --expert oracle --practice 5 | --practice has no effect: oracle learns nothing that could be
line tune --shifts 2 --out rules.yaml | --shifts is 2; settings are saved to --out from 32 shifts on
play --video a.mp4 --throws full | --throws goes with work shifts
play --video a.mp4 --env PnTLine-v0 --controller analytic | unknown controller of a line 'analytic'
play --picture x.png --env Nowhere-v0 | unknown environment 'Nowhere-v0'; known are PnTConveyor-v0,
publish none | run folder 'none' does not exist
publish folder | 'folder' is not a run folder: it has no args.yml
publish policy --shifts 3 | --shifts goes with work shifts; PnTRelease-v0 is judged by throws
publish policy --to file | cannot write 'file/PnTRelease-v0-waste-sac-seed0/README.md': Not a directory
dataset --throws 0 | --throws is 0; it must be at least 1
dataset --name waste | --name is 'waste'; it must be NAMESPACE/NAME-vN
dataset --name one/two-v0 --root datasets | 'one/two-v0' exists already in
dataset --name one/two-v0/three-v0 --root datasets | 'one/two-v0/three-v0' would lie in
dataset --root file | cannot read or write
dataset --controller policy --action-mode release_xyz | the policy of
dataset --env ToyThrow-v0 | environment 'ToyThrow-v0' has no single form
dataset --env PnTLine-v0 --expert atc --controller oracle | unknown controller of a line 'oracle'; known are
dataset --env PnTLine-v0 --expert atc --controller none.npz | scorer 'none.npz' does not exist
evaluate --env OneJointThrow-v0 --controller analytic --log x.csv | --log goes with PnTConveyor-v0, PnTRelease-v0 and
evaluate --controller analytic --log folder | cannot write 'folder': it is a folder
fit | give a log, or --design N, or --twins N
fit none.csv | cannot read log 'none.csv': No such file or directory
fit folder | cannot read log 'folder': Is a directory
fit file | log 'file' lacks the columns 'item', 'pick_x'
fit file --prior tau | 'tau' is no NAME=VALUE
fit file --out x.txt | --out is 'x.txt'; it must end in .yaml or .yml
fit file --level nowhere | unknown level 'nowhere'; known are
fit --design 0 | --design is 0; it must be at least 1
fit --design 3 --landings 30 | --landings goes with --twins, and has no effect here
fit file --plan x.csv | --plan goes with --design, and has no effect here
fit --design 5 --out x.yaml | --out goes with LOG, and has no effect here
fit --design 5 --page x.html | --page goes with LOG, and has no effect here
fit --twins 1 --json x.json | --json goes with LOG, and has no effect here
fit --twins 1 --landings 9 | --landings is 9; it must be at least 10
compare | a comparison needs at least 2 controllers, got 0
compare mlp | a comparison needs at least 2 controllers, got 1
compare analytic mlp --picture a.png | --picture is 'a.png'; it must end in .svg
demo --picks 0 | --picks is 0; it must be at least 1
line calibrate --throws 99 | --throws is 99; it must be at least 100
line calibrate --seed -1 | --seed is -1; it must be at least 0
line calibrate --num-envs 0 | --num-envs is 0; it must be at least 1
line calibrate --threads 0 | --threads is 0; it must be at least 1
line calibrate --level nowhere | unknown level 'nowhere'; known are line3, nominal, single
line calibrate --level near.yaml | level file 'near.yaml': robots 'a' at x 0 m and 'b' at 0.5 m have windows
line calibrate --level far.yaml --num-envs 2 | level 'far': no robot can throw an object into its bins
line calibrate --out folder | cannot write 'folder': it is a folder
line plan --recovery 1.5 | --recovery is 1.5; it must lie between 0 and 1
line plan --robots 7 | --robots is (7,); a line has 1 to 4 robots
line plan --controller best | unknown controller of a line 'best'; known are random, fifo
line plan --down second | --down is 'second'; it must be ROBOT:MINUTES
line plan --level nowhere | unknown level 'nowhere'; known are line3
line tune --level nowhere | unknown level 'nowhere'; known are line3
line tune --shifts 0 | --shifts is 0; it must be at least 1
line tune --seed -1 | --seed is -1; it must be at least 0
line tune --out . | cannot write '.': it is a folder
"""
"""`command | sentence`: how what is ours to say begins, and after three dots what it says further on."""
TYROS: Final = """
evaluate | --controller
evaluate --controller analytic --picks | --picks
evaluate --controller analytic --picks many | --picks
evaluate --controller analytic --picks 4 4 | 4
evaluate --controller analytic --picsk 4 | perhaps you meant --picks
train --algo dqn | --algo
publish | PATH
dataset --throws x | --throws
doctor extra | extra
line calibrate --throws x | --throws
line calibrate --typo 1 | --typo
line tune --what fifo | fifo
"""
"""`command | word`: what tyro finds in its own words, of which one names the mistake."""
PLACEHOLDERS: Final = {"LONG": "x" * 300}
"""Words that stand for what would not be read well in a table."""


def rows(table: str) -> list[Any]:
    """A table's lines as cases that bear the name of their command."""
    cases = [line.split(" | ") for line in table.strip().splitlines()]
    return [pytest.param(line, words, id=line) for line, words in cases]


PLAN = {
    "name": "small",
    "train_level": "waste",
    "levels": ["waste"],
    "entries": [{"label": "a", "controller": "analytic"}],
}
TEXTS = {
    "file": "text",
    "file.zip": "text",
    "text.yaml": "text",
    "other.yml": "PnTRelease-v0: {gamma: 0.0}",
    "typo.yaml": "binz: {}\n",
    "nominal.yaml": "mismatch: 9\n",
    "broken/x.json": "{",
    "plan.yaml": yaml.safe_dump(PLAN),
    "idle_plan.yaml": yaml.safe_dump({**PLAN, "entries": [{"label": "a", "controller": "nobody"}]}),
    "stacked.yaml": yaml.safe_dump({**PLAN, "entries": [{"label": "a", "controller": "analytic", "stack": 2}]}),
    "over.yaml": yaml.safe_dump({**PLAN, "entries": [{"label": "a", "controller": "sac", "stack": 8, "over": "mlp"}]}),
    "far_plan.yaml": yaml.safe_dump({**PLAN, "picks": -int("1" * 400)}),
    "near.yaml": yaml.safe_dump({"robots": [{"name": "a", "x": 0.0}, {"name": "b", "x": 0.5}]}),
    "far.yaml": yaml.safe_dump({"robots": [{"name": "a", "x": 0.0, "bins": [{"name": "far", "x": 0.0, "y": 3.5}]}]}),
    "nowhere.yaml": yaml.safe_dump({**PLAN, "levels": ["nowhere"]}),
}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with files of every kind, which no wrong line changes."""
    here = tmp_path_factory.mktemp("place")
    (here / "folder" / "full" / "thing").mkdir(parents=True)
    (here / "broken").mkdir()
    (here / "datasets" / "one" / "two-v0" / "data").mkdir(parents=True)
    for name, text in TEXTS.items():
        (here / name).write_text(text)
    np.savez(here / "x.npz", centre=np.zeros(3))
    shutil.copytree(POLICY, here / "policy")
    shutil.copytree(POLICY, here / "foreign")
    shutil.copy(here / "x.npz", here / "foreign" / "policy.npz")
    return here


def in_full(text: str) -> str:
    """A part of a table with what its placeholders stand for."""
    for name, value in PLACEHOLDERS.items():
        text = text.replace(name, value)
    return text


@pytest.mark.parametrize(("line", "said"), rows(WRONG))
def test_a_wrong_line_is_refused(place: Path, monkeypatch: pytest.MonkeyPatch, line: str, said: str) -> None:
    monkeypatch.chdir(place)
    before = sorted(place.rglob("*"))
    command, *options = shlex.split(in_full(line))
    words = refused(f"agents.{command}", *options)
    begin, _, further = in_full(said).partition(" ... ")
    assert words.startswith(f"error: {begin}")
    assert further in words
    assert sorted(place.rglob("*")) == before


@pytest.mark.parametrize(("line", "word"), rows(TYROS))
def test_a_line_that_does_not_parse_names_what_is_wrong(line: str, word: str) -> None:
    command, *options = shlex.split(line)
    assert word in refused(f"agents.{command}", *options).partition("; see ")[0]


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
@pytest.mark.parametrize("columns", ["40", "200"])
def test_a_box_of_any_width_and_colour_becomes_a_sentence(
    monkeypatch: pytest.MonkeyPatch, encoding: str, columns: str
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), encoding=encoding))
    for option, value, hint in (("--picsk", "4", "; perhaps you meant --picks N"), ("--seed", "x", "")):
        with pytest.raises(UsageError) as caught:
            _parse(Arguments, "this", ["--controller", "analytic", option, value])
        words = str(caught.value)
        assert words.isprintable()  # neither a break of the line nor a colour
        assert not set(words) & set("│╭╮╰╯─")
        assert option in words
        assert words.endswith(f"{hint}; see this --help")
