"""Fingerprints of what every environment gives: what a refactoring must keep to the last bit.

`python benchmarks/step_hashes.py --json before.json`, then after the change `--against before.json`. Fingerprints hold
on one machine with one set of versions: other vector instructions round differently.
"""

from __future__ import annotations

import hashlib
import json
import sys
from pathlib import Path
from typing import Any, cast

import gymnasium as gym
import numpy as np

import pnt_gym.errors
from agents.ground.files import write_json
from benchmarks.checks import check_parser, random_action

CONVEYOR = ("ideal", "nominal", "waste", "unseen", "tight", "fast")
DRIFTING = ("waste", "day", "steps", "drift_mix", "day_far")
ONE_JOINT = ("ideal", "nominal", "late", "paper", "contact")
GRIPPER = ("ideal", "nominal", "late", "patient", "drop", "belt")
LINE = (
    "single",
    "speed",
    {"name": "skills3_burst, flight", "base": "skills3_burst", "throws": "flight"},
    {"name": "skills3, full", "base": "skills3", "throws": "full"},
)
"""Shipped levels whose tables are there, and lines that throw."""
GRASP = (
    *({"name": f"{level}, flight", "base": level, "fidelity": "flight"} for level in ("grasp", "grasp_unseen")),
    {"name": "grasp_dense, flight", "base": "grasp_dense", "fidelity": "flight"},
    {"name": "grasp, belt", "base": "grasp", "fidelity": "flight", "grasp": {"picks": "belt"}},
    "grasp_soft",
    "grasp_plain",
    "grasp_shift",
)
CASES = {
    "PnTConveyor-v0": (CONVEYOR, ("release_point", "release_xyz", "virtual_goal")),
    "PnTAdapt-v0": (DRIFTING, ("release_point", "release_xyz", "virtual_goal")),
    "PnTRelease-v0": (CONVEYOR, ("release_point", "release_xyz", "virtual_goal", "fixed_throw")),
    "OneJointThrow-v0": (ONE_JOINT, ("virtual_goal", "release_state")),
    "OneJointSort-v0": (ONE_JOINT, ("virtual_goal", "release_state")),
    "OneJointAssembly-v0": (ONE_JOINT, ("virtual_goal", "release_state")),
    "GripperToss-v0": (GRIPPER, ("release", "release_point")),
    "PnTGrasp-v0": (GRASP, ("grasp",)),
    "PnTLine-v0": (LINE, ("choice",)),
}
CELLS = 4
SCALES = (0.3, 0.6, 1.0, 0.0)
"""Of the corrections of each step."""


def fingerprint(value: Any) -> str:
    """Fingerprint of an array's type, shape and bytes; NaN counts as one value."""
    array = np.ascontiguousarray(value)
    return hashlib.sha256(f"{array.dtype} {array.shape}".encode() + array.tobytes()).hexdigest()[:16]


def seen(observation: Any) -> dict[str, list[Any]]:
    """The arrays of an observation by name, in lists of one."""
    if isinstance(observation, dict):
        return {f"observation/{name}": [value] for name, value in cast("dict[str, Any]", observation).items()}
    return {"observation": [observation]}


def fingerprints(env_id: str, level: Any, mode: str) -> dict[str, str]:
    """Fingerprints of all that a few steps of a vector environment return, by name, or of the refusal of a level."""
    try:
        env = gym.make_vec(env_id, num_envs=CELLS, level=level, action_mode=mode)
    except pnt_gym.errors.ConfigError as error:
        return {"refused": str(error)}
    random = np.random.default_rng(7)
    observation, info = env.reset(seed=11)
    parts: dict[str, list[Any]] = {**seen(observation), "reward": [], "ended": []}
    parts |= {f"info/{name}": [value] for name, value in info.items() if not name.startswith("_")}
    for scale in SCALES:
        observation, reward, over, cut, info = env.step(random_action(env, info, random, scale))
        for name, values in seen(observation).items():
            parts[name] += values
        parts["reward"].append(reward)
        parts["ended"].append(np.stack([over, cut]))
        for name, value in info.items():
            if not name.startswith("_") and isinstance(value, np.ndarray) and value.dtype != object:
                parts.setdefault(f"info/{name}", []).append(value)
    env.close()
    return {name: fingerprint(np.stack(values)) for name, values in parts.items()}


def main() -> int:
    """Write fingerprints, or compare them with those of another code state."""
    parser = check_parser(__doc__)
    parser.add_argument("--json", type=Path, help="where to write the fingerprints")
    parser.add_argument("--against", type=Path, help="fingerprints of another code state")
    parser.add_argument("--env", choices=sorted(CASES), help="only this environment")
    args = parser.parse_args()
    hashes: dict[str, dict[str, str]] = {}
    for env_id, (levels, modes) in CASES.items():
        for level in levels if args.env in (None, env_id) else ():
            for mode in modes:
                name = level if isinstance(level, str) else level["name"]
                hashes[f"{env_id}/{name}/{mode}"] = fingerprints(env_id, level, mode)
    if args.json:
        write_json(args.json, {"version": pnt_gym.__version__, "made": hashes})
    if not args.against:
        return 0
    return compare(hashes, json.loads(args.against.read_text())["made"])


def compare(hashes: dict[str, dict[str, str]], before: dict[str, dict[str, str]]) -> int:
    """Say what differs, and which cases are not known of before; 1 if anything differs, else 0."""
    common = [case for case in hashes if case in before]
    differences = [
        f"{case}: {', '.join(names)}"
        for case in common
        if (names := [n for n in sorted(hashes[case] | before[case]) if hashes[case].get(n) != before[case].get(n)])
    ]
    print("\n".join(differences) or f"{len(common)} cases: all fingerprints are equal")
    if new := [case for case in hashes if case not in before]:
        print(f"{len(new)} cases are not in the older file: {', '.join(new)}")
    return int(bool(differences))


if __name__ == "__main__":
    sys.exit(main())
