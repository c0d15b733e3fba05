"""Wrong command lines: exit code 2, a sentence that names what is wrong, and nothing printed or left behind.

What can be wrong follows from the types of the options and of the levels' keys. The sentences that no type implies
stand in one table, each by its beginning: files and folders of another kind, and options that do not go together.
"""

import io
import re
import shlex
import shutil
import sys
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from agents.evaluate import Arguments
from agents.ground.cli import UsageError, _parse
from agents.ground.places import POLICY
from pnt_gym.reading import yaml_text
from tests.tools.commands import call_here
from tests.tools.wrong import FAMILIES, MODULES, NEEDED, Key, Option, files_in, keys, lacks, module_of, options

WRONG: Final = r"""
evaluate --controller "" | '.' holds neither foreign.zip nor best_model.zip
evaluate --controller analytic --level text.yaml | level file 'text.yaml' must hold a mapping of settings, it h
evaluate --controller analytic --level typo.yaml | level file 'typo.yaml': unknown key 'binz'
evaluate --controller analytic --level day | level 'day' drifts, and the observations of this environment do not show
evaluate --controller kalman | controller 'kalman' needs observations of the previous landing; u
evaluate --controller analytic --env CartPole-v1 --level waste | environment 'CartPole-v1' takes no level
evaluate --controller analytic --json folder | cannot write 'folder': it is a folder
evaluate --controller analytic --json LONG/x.json | cannot write 'x ... File name too long
evaluate --controller analytic --shifts 2 | --shifts goes with work shifts; PnTConveyor-v0 is judged by throws
evaluate --controller analytic --load x.npz | --load: controller 'analytic' learns nothing that could be s
evaluate --controller ridge --load none.npz | 'none.npz' does not exist
evaluate --controller ridge --load folder | 'folder' holds no saved controller: Is a directory
evaluate --controller ridge --load x.npz | 'x.npz' holds no saved controller
evaluate --controller ridge --save file/x.npz | cannot write 'file/x.npz': File exists
evaluate --controller none.zip --trust | model 'none.zip' does not exist
evaluate --controller file.zip | 'file.zip' is not a run folder of `train`: loading it runs ... give --trust
evaluate --controller file.zip --trust | 'file.zip' is damaged: file.zip is truncated or not a model
evaluate --controller folder | 'folder' is not a run folder: it has no args.yml
evaluate --controller LONG.zip | cannot read or write 'x ... File name too long
evaluate --controller mlp --action-mode release_xyz | controller 'mlp' shifts the landing and needs an action of 2
evaluate --controller policy --action-mode release_xyz | the policy of 'policy' takes observations (26,) and gives ac
evaluate --controller foreign | 'foreign/policy.npz' is damaged: policy.npz is truncated or holds no policy
evaluate --env PnTLine-v0 --controller atc --picks 9 | --picks goes with throws; PnTLine-v0 is judged by work shifts
evaluate --env PnTLine-v0 --controller atc --release ridge | level 'single' ... set `throws` to 'flight' or 'full'
evaluate --env PnTLine-v0 --controller atc --video a.mpeg | --video is 'a.mpeg'; it must end in .mp4 or .gif
evaluate --env OneJointThrow-v0 --controller analytic --log x.csv | --log goes with PnTConveyor-v0, PnTRelease-v0 and
train --env CartPole-v1 | environment 'CartPole-v1' has no core
train --env PnTLine-v0 --algo sac | algorithm sac does not learn from decisions of PnTLine-v0; algorithms there are
train --env PnTLine-v0 --stack 2 | --stack, --over and --fidelity go with throws
train --full-last 10 | --full-last goes with --fidelity flight
train --algo recurrent_ppo | algorithm 'recurrent_ppo' needs observations that mark the beginning of a shift
train --over static | controller 'static' needs observations of the previous landing; use --env PnTAdapt-v0
train --config other.yml | hyperparameters 'other.yml' have no entry for 'PnTConveyor-v0'; entries are PnTRelease-v0
train --config none.yml | cannot read hyperparameters 'none.yml': No such file or dire
train --out folder/full | 'folder/full' exists already; choose another --out, or conti
train --out file/run --env ToyThrow-v0 --steps 8 | cannot write run folder 'file/run': Not a directory
train --out LONG | cannot read or write 'x ... File name too long
train --resume file | run folder 'file' does not exist
train --resume folder | 'folder' is not a run folder: it has no args.yml
train --resume policy | run folder 'policy' is damaged: it has no checkpoint
train --resume policy --algo ppo | --algo cannot be changed with --resume, because the run folder holds
benchmark --config none.yaml | cannot read benchmark 'none.yaml': No such file or directory
benchmark --config text.yaml | benchmark 'text.yaml': it is 'text': input should be a section, with keys name,
benchmark --config plan.yaml --out folder | cannot write 'folder': it is a folder
benchmark --config plan.yaml --work file --out o.json | cannot write 'file/piece.json': File exists
benchmark --config far_plan.yaml | benchmark 'far_plan.yaml': picks is -1111111111 ... input should be greater
benchmark --config stacked.yaml | benchmark 'stacked.yaml': entry 'a': `stack`, `over` and `fidelity` can be used only
benchmark --config over.yaml | benchmark 'over.yaml': entry 'a': over: unknown controller that needs no practice 'mlp'
reproduce hassan --figures file | cannot write 'file/drawing.svg': File exists
report --results broken | cannot read 'broken/x.json': it is not valid JSON: Expecting
report --results file | 'file' holds no results yet; `python -m agents.benchmark` makes some
play | give one of --video FILE.mp4, --picture FILE.png and --viewe
play --picture x.png --at inf | --at is inf s; it must be finite and not negative
play --video a.mp4 --picture x.png | give one of --video FILE.mp4, --picture FILE.png and --viewe
play --picture x.png --picks 2 | --picks goes with --video, and has no effect here
play --picture x.png --env ToyThrow-v0 | environment 'ToyThrow-v0' has no pictures: its core, a ToyCore, has no method
publish policy --no-model --env ToyThrow-v0 | environment 'ToyThrow-v0' has no pictures: its core, a ToyCore
publish policy --shifts 3 | --shifts goes with work shifts; PnTRelease-v0 is judged by throws
publish policy --to file | cannot write 'file/PnTRelease-v0-waste-sac-seed0/README.md': Not a directory
dataset --expert oracle --practice 5 | --practice has no effect: oracle and random learn nothing that could be sent to
dataset --name waste | --name is 'waste'; it must be NAMESPACE/NAME-vN
dataset --name one/two-v0 --root datasets | 'one/two-v0' exists already in
dataset --env ToyThrow-v0 | environment 'ToyThrow-v0' has no single form
dataset --env PnTLine-v0 --expert atc --controller none.npz | scorer 'none.npz' does not exist
line tune --shifts 2 --out rules.yaml | --shifts is 2; settings are saved to --out from 32 shifts on
fit | give a log, or --design N, or --twins N
fit file | log 'file' lacks the columns 'item', 'pick_x'
fit file --prior tau | 'tau' is no NAME=VALUE
fit file --out x.txt | --out is 'x.txt'; it must end in .yaml or .yml
fit --design 3 --landings 30 | --landings goes with --twins, and has no effect here
compare mlp | a comparison needs at least 2 controllers, got 1
compare analytic mlp --picture a.png | --picture is 'a.png'; it must end in .svg
line calibrate --level near.yaml | level file 'near.yaml': robots 'a' at x 0 m and 'b' at 0.5 m have windows
line calibrate --level far.yaml --num-envs 2 | level 'far': no robot can throw an object into its bins
line plan --recovery 1.5 | --recovery is 1.5; it must lie between 0 and 1
line plan --robots 7 | --robots is (7,); a line has 1 to 4 robots
line plan --down second | --down is 'second'; it must be ROBOT:MINUTES
"""
"""`command | sentence`: how what is ours to say begins, and after three dots what it says further on."""
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
    "broken/x.json": "{",
    "plan.yaml": yaml.safe_dump(PLAN),
    "stacked.yaml": yaml.safe_dump({**PLAN, "entries": [{"label": "a", "controller": "analytic", "stack": 2}]}),
    "over.yaml": yaml.safe_dump({**PLAN, "entries": [{"label": "a", "controller": "sac", "stack": 8, "over": "mlp"}]}),
    "far_plan.yaml": yaml.safe_dump({**PLAN, "picks": -int("1" * 400)}),
    "near.yaml": yaml.safe_dump({"robots": [{"name": "a", "x": 0.0}, {"name": "b", "x": 0.5}]}),
    "far.yaml": yaml.safe_dump({"robots": [{"name": "a", "x": 0.0, "bins": [{"name": "far", "x": 0.0, "y": 3.5}]}]}),
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


def refusal_of(place: Path, command: str, *words: str) -> str:
    """The words with which a command refuses; it prints and writes nothing."""
    before = files_in(place)
    done = call_here(command, *words, folder=place)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert re.fullmatch(r"error: .+\n(- .+\n)*", done.stderr), done.stderr
    assert max(map(len, done.stderr.splitlines())) < 700, done.stderr
    assert files_in(place) == before
    return done.stderr


NUMBERS: Final = [
    pytest.param(option, value, id=f"{option.command} {option.word} {value}")
    for option in options()
    for value in ("zzz", "-1000000000", *(["nan"] if float in option.kinds else []))
    if {int, float} & {*option.kinds}
]


@pytest.mark.parametrize(("option", "value"), NUMBERS)
def test_what_is_no_number_of_an_option_is_refused_by_name(place: Path, option: Option, value: str) -> None:
    said = refusal_of(place, module_of(option.command), *NEEDED.get(option.command, ()), option.word, value)
    assert option.word in said


@pytest.mark.parametrize("command", MODULES)
def test_an_option_that_there_is_not_is_refused_by_name(place: Path, command: str) -> None:
    said = refusal_of(place, module_of(command), *NEEDED.get(command, ()), "--nonesuch", "1")
    assert "--nonesuch" in said


@pytest.mark.parametrize("command", MODULES)
def test_what_a_command_needs_is_asked_for_by_name(place: Path, command: str) -> None:
    for option in options():
        if option.command == command and (option.is_needed or (option.word and option.has_one_value)):
            words = () if option.is_needed else (*NEEDED.get(command, ()), option.word)
            said = refusal_of(place, module_of(command), *words)
            assert (option.word or "give ") in said


def wrong_keys() -> st.SearchStrategy[Key]:
    """Any wrong key of any family of levels."""
    return st.sampled_from([key for family in FAMILIES for key in (*keys(family), *lacks(family))])


@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(key=st.deferred(wrong_keys))
def test_a_wrong_key_of_a_level_ends_a_command(place: Path, tmp_path: Path, key: Key) -> None:
    (tmp_path / "x.yaml").write_text(yaml_text(key.level()))
    env_id, _ = FAMILIES[key.family]
    controller = "atc" if env_id == "PnTLine-v0" else "analytic"
    words = ("--env", env_id, "--controller", controller, "--level", str(tmp_path / "x.yaml"), "--json", "o.json")
    assert key.name in refusal_of(place, "agents.evaluate", *words)


@pytest.mark.parametrize(("line", "said"), rows(WRONG))
def test_a_wrong_line_is_refused(place: Path, line: str, said: str) -> None:
    command, *words = shlex.split(in_full(line))
    words = refusal_of(place, f"agents.{command}", *words)
    begin, _, further = in_full(said).partition(" ... ")
    assert words.startswith(f"error: {begin}")
    assert further in words


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
