"""Robots by their data sheets: what a sheet may say, and what planner, flights, lines and pictures make of it."""

from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from agents.ground.environments import core_of, make_vector
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.robot import T3KR, WAY, RobotSheet, sheet_names
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError
from pnt_gym.planning import EllipticWorkspace, MotionLimits, plan_release, rest_to_rest
from pnt_gym.robots.t3kr import geometry

OWN: dict[str, Any] = {
    "name": "mine", "velocity": 8.0, "acceleration": 90.0, "standard_cycle": 0.45, "payload": 2.0, "energy": 100.0,
    "reach": {"shape": "ring", "radius": 0.75, "hole": 0.15, "y": -0.45}, "height": [-0.95, -0.40],
}  # fmt: skip
"""A robot of a user's."""
FLIGHTS: dict[str, Any] = {"base": "waste", "robot": OWN, "fidelity": "flight", "limits": {"percent": [60]}}


def without(sheet: Mapping[str, Any], *names: str, **changes: Any) -> dict[str, Any]:
    return {name: value for name, value in sheet.items() if name not in names} | changes


@pytest.mark.parametrize("name", sheet_names())
def test_a_standard_cycle_takes_what_the_sheet_says(name: str) -> None:
    """Six strokes along a rectangle would stop at its corners: half a cycle is one stroke of its length."""
    sheet = RobotSheet.model_validate(name)
    limits = MotionLimits(sheet.velocity, sheet.acceleration, sheet.full_jerk)
    cycle = 2.0 * rest_to_rest([[WAY, 0.0, 0.0]], limits).durations.sum()
    assert sheet.cycle == pytest.approx(cycle, rel=1e-9)
    assert cycle == pytest.approx(sheet.standard_cycle or cycle, rel=0.1)
    assert sheet.source


def test_the_t3kr_is_the_robot_of_the_paper_and_of_its_model() -> None:
    paper, model = MotionLimits.t3kr(), geometry.T3KR
    assert (T3KR.velocity, T3KR.acceleration, T3KR.full_jerk) == (paper.velocity, paper.acceleration, paper.jerk)
    assert T3KR.workspace == EllipticWorkspace(model.workspace_x, model.workspace_y, model.z_min, model.z_max)
    assert ConveyorConfig.load("waste").robot == ConveyorConfig.load({"base": "waste", "robot": "t3kr"}).robot == T3KR
    assert T3KR.has_model
    assert not RobotSheet.model_validate(OWN).has_model


@pytest.mark.parametrize(
    ("robot", "said"),
    [
        ("deltta", "unknown robot 'deltta'"),
        (without(OWN, "standard_cycle"), "robot.jerk and standard_cycle are missing"),
        (without(OWN, standard_cycle=0.1), "robot.standard_cycle is 0.1 s; with velocity 8 m/s and acceleration 90"),
        (without(OWN, jerk=100.0), "robot.standard_cycle is 0.45 s, and the limits give 0.969 s"),
        (without(OWN, height=[-0.4, -0.9]), "robot.height runs from -0.4 to -0.9 m"),
        (without(OWN, payload=0.02), "carries at most 0.02 kg"),
        (without(OWN, reach={"shape": "circle", "radius": 0.1, "x": 3.0}), "'mine' covers 0 % of the window"),
        (without(OWN, height=[-0.4, 0.0]), "'mine' covers 0 % of the window"),
        (without(OWN, reach={"shape": "circle", "semi_x": 0.4}), "a reach of shape 'circle' has 'radius'"),
        (without(OWN, reach={"shape": "ring", "radius": 0.4, "hole": 0.5}), "hole is 0.5 m; it must be below"),
        (without(OWN, accuracy=-1.0), "robot.accuracy"),
        (without(OWN, velocity="fast"), "robot.velocity"),
        (without(OWN, speed=3.0), "robot.speed"),
    ],
)  # fmt: skip
def test_a_sheet_of_no_possible_robot_is_refused_in_a_sentence(robot: Any, said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        ConveyorConfig.load({**FLIGHTS, "robot": robot})
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_joints_that_nobody_knows_are_not_simulated() -> None:
    with pytest.raises(ConfigError, match="robot is 'mine', known by its data sheet alone, without joints and motors"):
        ConveyorConfig.load({**FLIGHTS, "fidelity": "full"})
    with pytest.raises(ConfigError, match=r"planner is 'ellipse' and robot\.reach is a ring"):
        ConveyorConfig.load({**FLIGHTS, "planner": "ellipse"})
    line = {"base": "skills3", "cell": {"robot": "delta_1300"}}
    assert [cell.robot.name for cell in LineConfig.load(line).cells()] == ["delta_1300"] * 3
    with pytest.raises(ConfigError, match="throws is 'full' and robot is 'delta_1300', known by the data sheet alone"):
        LineConfig.load({**line, "throws": "full"})


def test_throws_keep_to_the_limits_and_the_reach_of_the_sheet() -> None:
    with closing(make_vector("PnTConveyor-v0", FLIGHTS, 32, 1)) as env:
        env.reset(seed=4)
        core, found, landed = core_of(env), list[Any](), list[float]()
        own, space = core.config.robot, core.config.robot.workspace
        for _ in range(4):
            context, (plan, _) = core.context, core.plan(np.zeros(env.action_space.shape, dtype=np.float32))
            motion = core.cell.planner.mover.throw(context.pick, plan, context.throw_limits, context.ceiling)
            path = motion.path.sample(np.linspace(0.0, motion.stop_time.max(), 200))
            assert space.contains(path.position).all(), "hands leave the ring"
            assert np.linalg.norm(path.velocity, axis=-1).max() <= 0.6 * own.velocity * (1 + 1e-9)
            assert np.linalg.norm(path.acceleration, axis=-1).max() <= 0.6 * own.acceleration * (1 + 1e-9)
            info = env.step(np.zeros(env.action_space.shape, dtype=np.float32))[4]
            found.append(info["energy"] / info["cycle_time"])
            landed += info["landing_error"][info["picked"] & ~info["dropped"]].tolist()
    assert np.allclose(found, 100.0 / 0.45), "energy goes with time"
    assert 0.01 < np.nanmedian(landed) < 0.15


def test_a_planned_throw_ends_before_the_hole() -> None:
    """The free optimum lies in the hole, and the bound one on its border, by the distances of points of their ways."""
    ring = EllipticWorkspace(1.0, 1.0, -1.0, 1.0, hole=0.25)
    limits = MotionLimits.t3kr(80)
    free = plan_release((-0.34, 0.02, -0.8), (1.5, 0.1, -0.8), limits, ceiling=0.5)
    bound = plan_release((-0.34, 0.02, -0.8), (1.5, 0.1, -0.8), limits, ceiling=0.5, workspace=ring)
    shares = np.linspace(0.0, 1.0, 1001)[:, None]
    ways = [np.array([-0.34, 0.02, -0.8]) * (1 - shares) + shares * np.asarray(p.position) for p in (free, bound)]
    near = [np.hypot(way[:, 0], way[:, 1]).min() for way in ways]
    assert near[0] < 0.24
    assert near[1] == pytest.approx(0.25)
    assert bound.workspace_active
    assert ring.margin([[0.0, 0.1, 0.0], [0.3, 0.0, 0.0], [0.9, 0.9, 0.0]]) == pytest.approx(
        [-0.15, 0.05, -0.2728], abs=1e-4
    )


def test_a_hand_errs_as_its_sheet_says() -> None:
    """An error of the hand moves the landing by itself; other draws stay."""
    landings = []
    for accuracy in (0.0, 0.005):
        level = {**FLIGHTS, "robot": without(OWN, accuracy=accuracy)}
        with closing(make_vector("PnTRelease-v0", level, 256, 1)) as env:
            env.reset(seed=1)
            error = core_of(env).context.objects.hand_error.copy()
            info = env.step(np.zeros(env.action_space.shape, dtype=np.float32))[4]
            landings.append((error, info["landing_along"], info["picked"]))
    (none, exact, picked), (error, moved, _) = landings
    assert not none.any()
    assert np.std(error) == pytest.approx(0.005, rel=0.15)
    assert np.array_equal(picked, landings[1][2])
    far = (moved - exact)[picked & np.isfinite(moved) & np.isfinite(exact)]
    assert 0.004 < np.std(far[np.abs(far) < 0.05]) < 0.012


def test_another_sheet_is_a_file_of_the_users(tmp_path: Path) -> None:
    """Nothing of the package changes: one section of a level, for a cell, and for one robot of a line."""
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(FLIGHTS))
    line = {
        "base": "line3", "throws": "flight", "duration": 20.0,
        "robots": [
            {"name": "a", "x": 0.0},
            {"name": "b", "x": 1.6, "robot": OWN},
            {"name": "c", "x": 3.2, "robot": "scara_700"},
        ],
    }  # fmt: skip
    (tmp_path / "line.yaml").write_text(yaml.safe_dump(line))
    with closing(make_vector("PnTConveyor-v0", tmp_path / "mine.yaml", 2, 1)) as env:
        env.reset(seed=0)
        assert core_of(env).config.robot.name == "mine"
    with closing(make_vector("PnTLine-v0", tmp_path / "line.yaml", 2, 1)) as env:
        env.reset(seed=0)
        by, energy = set[int](), dict[int, list[float]]()
        for _ in range(60):
            info = env.step(np.zeros(2, dtype=np.int64))[4]
            for robot, joules in zip(info["by"], info["energy"], strict=True):
                by.add(int(robot))
                energy.setdefault(int(robot), []).append(float(joules))
    assert by == {0, 1, 2}
    assert np.nanmean(energy[0]) < 60.0 < np.nanmean(energy[1]), "mechanical work of ours, electricity of the sheet"


def test_a_line_of_other_robots_needs_a_table_of_its_own() -> None:
    plain = LineConfig.load("line3")
    named = LineConfig.load({"base": "line3", "cell": {"robot": "t3kr"}})
    other = LineConfig.load({"base": "line3", "cell": {"robot": "delta_1600"}})
    assert plain.digest() == named.digest() != other.digest()
    assert (plain.finest, other.finest) == ("full", "flight")
    assert other.simulated().throws == "flight"


def test_most_sheets_state_a_standard_cycle_which_their_limits_keep() -> None:
    sheets = [RobotSheet.model_validate(name) for name in sheet_names()]
    stated = [sheet for sheet in sheets if sheet.standard_cycle is not None]
    assert len(stated) >= 0.8 * sum(sheet.model is None and sheet != T3KR for sheet in sheets) >= 4
