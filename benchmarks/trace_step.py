"""Count the files and functions of the project that one `env.step` enters, their calls, and how deep the calls go.

`python benchmarks/trace_step.py [--env ID] [--level NAME] [--list]` measures with `sys.setprofile` after a warm-up.
A comprehension or a generator expression counts as part of the function in which it stands; a lambda is a function.
Fewer functions are a symptom of a straight path of the data, and no goal by themselves.
"""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any, Final, final

import gymnasium as gym
import numpy as np

import pnt_gym
from benchmarks.checks import check_parser
from pnt_gym.errors import PntGymError

ROOT = Path(pnt_gym.__file__).resolve().parent
WARM_UP: Final = 2
"""Steps that are not counted, since they compile and fill caches."""
MOST_STEPS: Final = 100
"""Steps in which an object must be picked."""
COMPREHENSIONS: Final = frozenset({"<listcomp>", "<dictcomp>", "<setcomp>", "<genexpr>"})
"""Frames that belong to the function around them; since Python 3.12 only a generator expression has one."""


class CheckError(PntGymError):
    """A measurement that is not possible."""


@final
@dataclass
class Trace:
    """What a profiled call entered; frames outside the package do not count."""

    functions: Counter[tuple[str, str]] = field(default_factory=Counter[tuple[str, str]])
    depth: int = 0
    deepest: int = 0

    def __call__(self, frame: FrameType, event: str, _: Any) -> None:
        """Take in one event of `sys.setprofile`."""
        code = frame.f_code
        if event not in ("call", "return") or not code.co_filename.startswith(str(ROOT)):
            return
        if code.co_name in COMPREHENSIONS:
            return
        self.depth += 1 if event == "call" else -1
        if event == "call":
            self.functions[code.co_filename, code.co_qualname] += 1
            self.deepest = max(self.deepest, self.depth)

    @property
    def files(self) -> Counter[str]:
        """Calls by file."""
        calls_by_file: Counter[str] = Counter()
        for (file, _), calls in self.functions.items():
            calls_by_file[str(Path(file).relative_to(ROOT))] += calls
        return calls_by_file


def trace_step(env_id: str, level: str | None = None) -> tuple[Trace, dict[str, Any]]:
    """Trace of the first step after a warm-up of two whose object is picked and so thrown, and the `info` of this step.

    Actions are 0.1 or the first choice that exists; a level of None is the default. The one-joint arm holds every
    object, and its `info` has no "picked"; elsewhere a step without "picked" tries to grasp and throws nothing.
    """
    is_held = env_id.startswith("OneJoint")
    env = gym.make(env_id, **({"level": level} if level else {})).unwrapped
    _, info = env.reset(seed=0)
    for count in range(MOST_STEPS):
        trace, action = Trace(), _action(env, info)
        sys.setprofile(trace)
        try:
            _, _, over, cut, info = env.step(action)
        finally:
            sys.setprofile(None)
        if count >= WARM_UP and info.get("picked", is_held):
            env.close()
            return trace, info
        if over or cut:
            _, info = env.reset()
    raise CheckError(f"no object of {MOST_STEPS} was picked; choose another level")


def _action(env: gym.Env[Any, Any], info: dict[str, Any]) -> Any:
    """Small numbers, or on a line the first choice that its mask allows."""
    if "action_mask" in info:
        return int(np.argmax(info["action_mask"]))
    return np.full(env.action_space.shape or (), 0.1, dtype=np.float32)


def main() -> None:
    """Print the figures, and with --list every function."""
    parser = check_parser(__doc__)
    parser.add_argument("--env", default="PnTConveyor-v0", choices=pnt_gym.ENV_IDS)
    parser.add_argument("--level", help="the environment's default unless given")
    parser.add_argument("--list", action="store_true", help="every function with its calls")
    args = parser.parse_args()
    try:
        trace, _ = trace_step(args.env, args.level)
    except PntGymError as error:
        parser.error(str(error))
    print(
        f"{args.env} {args.level or 'default level'}: {len(trace.files)} files, {len(trace.functions)} functions, "
        f"{sum(trace.functions.values())} calls, {trace.deepest} deep"
    )
    if args.list:
        for file in sorted(trace.files):
            names = [f"{name} x{n}" for (path, name), n in trace.functions.items() if path == str(ROOT / file)]
            print(f"{file}: {', '.join(names)}")


if __name__ == "__main__":
    main()
