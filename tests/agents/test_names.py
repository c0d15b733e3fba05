"""A name that nothing has is refused in one sentence, by every option of every command that takes names."""

from pathlib import Path
from typing import Final, Literal, get_origin

import pytest
import yaml

from tests.tools.commands import answered, refused
from tests.tools.wrong import NEEDED, Option, module_of, options

TEXTS: Final = {
    "by",
    "about",
    "name",
    "author",
    "author_email",
    "code_permalink",
    "cluster",
    "address",
    "trial",
    "host",
    "want",
}
"""Options whose text names nothing that exists."""
VALUES: Final = {"down": "{}:1", "settings": "{}=1", "prior": "{}=1"}
"""Form of the values of options that hold more than a name."""
WORDS: Final = {
    "show": "level", "like": "level", "where": "shipped policy", "settings": "setting", "env": "environment",
    "action_mode": "action_mode",
}  # fmt: skip
"""What the sentence calls a name, where not by the option that takes it."""
PLAN: Final = {
    "name": "small",
    "train_level": "waste",
    "levels": ["waste"],
    "entries": [{"label": "a", "controller": "analytic"}],
}


def noun(option: Option) -> str:
    """What the sentence calls what an option names."""
    return WORDS.get(option.name, option.name.removesuffix("s").replace("_", "-"))


def has_names(option: Option) -> bool:
    """Whether an option takes names: texts or choices."""
    is_choice = any(get_origin(part) is Literal for part in option.kinds)
    return option.command != "report" and option.name not in TEXTS and (str in option.kinds or is_choice)


OPTIONS: Final = [
    pytest.param(option, id=f"{option.command} {option.name}") for option in options() if has_names(option)
]


@pytest.fixture
def here(desk: Path, toy_training: Path) -> Path:
    (desk / "plan.yaml").write_text(yaml.safe_dump(PLAN))
    (desk / "kept").symlink_to(toy_training)
    return desk


def line(option: Option, name: str) -> list[str]:
    """A command line that is right but for one name."""
    needed = NEEDED.get(f"{option.command} --{option.name}", NEEDED.get(option.command, ()))
    if not option.word:  # instead of the positional argument that the command needs
        needed = needed[1:] if option.command != "compare" else needed[:1]
    return [*needed, *([option.word] if option.word else []), VALUES.get(option.name, "{}").format(name)]


@pytest.mark.parametrize("option", OPTIONS)
def test_an_unknown_name_is_one_sentence_that_names_option_and_value(here: Path, option: Option) -> None:
    before = sorted(here.rglob("*"))
    said = refused(module_of(option.command), *line(option, "nonesuch"))
    assert "'nonesuch'" in said or "'shipped:nonesuch'" in said
    assert noun(option) in said
    assert "unknown" in said
    assert "known are" in said or "there is none" in said
    assert sorted(here.rglob("*")) == before


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("evaluate", "--controller", "Analytic"), "unknown controller 'Analytic'; did you mean 'analytic'? known are"),
        (("evaluate", "--controller", "1"), "unknown controller '1'; known are "),
        (("evaluate", "--controller", "mlp", "--option", "widht=9"), "unknown setting 'widht'; did you mean 'width'?"),
        (("evaluate", "--controller", "shipped:waste-sac", "--option", "gain=1"), "setting 'gain'; there is none"),
        (("train", "--algo", "SAC"), "--algo: unknown value 'SAC'; did you mean 'sac'? known are maskable_ppo, ppo, "),
        (("levels", "--show", "skills"), "unknown level 'skills'; did you mean 'PnTLine/skills3'? known are PnTLine/s"),
        (("fit", "--design", "1", "--free", "camara_x"), "free: unknown parameter 'camara_x'; did you mean 'camera_x'"),
        (("compare", "analytic", "mlp", "--figures", "sucess"), "unknown figure 'sucess'; did you mean 'success'? kno"),
        (("compare", "analytic", "mlp", "--figures", "success", "success"), "figures: 'success' is given 2 times; giv"),
        (("compare", "analytic", "analytic"), "controllers: 'analytic' is given 2 times; give it once"),
        (("evaluate", "--controller", "mlp", "--option", "width=8", "--option", "width=9"), "'width' is given 2 times"),
        (("line tune", "--what", "atc", "atc"), "what: 'atc' is given 2 times; give it once"),
        (("line plan", "--skills", "all", "all"), "skills: 'all' is given 2 times; give it once"),
        (("line plan", "--robots", "2", "2"), "robots: 2 is given 2 times; give it once"),
        (("publish", "kept", "--levels", "waste", "waste"), "levels: 'waste' is given 2 times; give it once"),
        (("reproduce", "choe", "--only", "length", "--only", "length"), "only: 'length' is given 2 times; give it on"),
        (("benchmark", "--config", "plan.yaml", "--only", "a", "--only", "a"), "only: 'a' is given 2 times; give it "),
    ],
    ids=str,
)
def test_what_was_meant_is_told_and_nothing_is_given_twice(here: Path, words: tuple[str, ...], said: str) -> None:
    del here
    assert said in refused(f"agents.{words[0]}", *words[1:])


ENDS: Final = """
import sys

from agents.controllers import Controller


class Base(Controller):
    name = "own"

    def act(self, observation):
        sys.exit(0)


class Born(Base):
    def __init__(self):
        raise SystemExit


class Odd(Base):
    def act(self, observation):
        raise BaseException("over")
"""
ACTS: Final = ("agents.evaluate", "--env", "ToyThrow-v0", "--num-envs", "4", "--picks", "4")


@pytest.mark.parametrize("ending", ["sys.exit(0)", "exit()", "raise SystemExit", "raise BaseException('over')"])
@pytest.mark.parametrize("option", [("--controller", "{}:Own"), ("--controller", "mlp", "--env", "{}:Own-v0")])
def test_a_script_without_a_guard_is_an_error(desk: Path, option: tuple[str, ...], ending: str) -> None:
    module = f"script_{abs(hash((option, ending)))}"
    (desk / f"{module}.py").write_text(f"import sys\n{ending}\n")
    said = refused("agents.evaluate", *(word.format(module) for word in option))
    assert said.startswith(f"error: module {module!r} ended the interpreter with ")
    assert 'must stand under `if __name__ == "__main__":`' in said


@pytest.mark.parametrize("name", ["Base", "Born", "Odd"])
def test_a_controller_that_ends_the_interpreter_is_an_error(desk: Path, name: str) -> None:
    module = f"ends_{name.lower()}"
    (desk / f"{module}.py").write_text(ENDS)
    subject = f"controller '{module}:Born'" if name == "Born" else "a module or class of yours"
    assert refused(*ACTS, "--controller", f"{module}:{name}").startswith(f"error: {subject} ended the interpreter with")


def test_a_controller_that_ends_a_worker_process_is_an_error(desk: Path) -> None:
    (desk / "ends_work.py").write_text(ENDS)
    entries = [{"label": label, "controller": f"ends_work:{label}"} for label in ("Base", "Odd")]
    plan = {**PLAN, "env": "PnTRelease-v0", "picks": 16, "entries": entries}
    (desk / "plan.yaml").write_text(yaml.safe_dump(plan))
    said = refused("agents.benchmark", "--config", "plan.yaml", "--jobs", "1", "--work", "work", "--out", "out.json")
    assert "a module or class of yours ended the interpreter with" in said
    assert not (desk / "out.json").exists()


def test_what_a_command_itself_ends_with_stays(desk: Path) -> None:
    """`fit` and `verify` have exit codes of their own, which no sentence about user code takes."""
    from agents.ground.cli import Exit, user_code  # noqa: PLC0415 - beside what is tested

    del desk
    with pytest.raises(Exit) as caught, user_code("nobody"):
        raise Exit(1)
    assert caught.value.code == 1
    assert answered("agents.levels")[0] == 0
