"""The pallets' geometry, and which flights pass them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from papers.miyashita.passing import SAMPLES, clear_vertical_speeds, clearance, flight_poses, gaps
from pnt_gym.cells.one_joint.pallets import (
    ASSEMBLY,
    BACK_PLAY,
    LIP_PLAY,
    SORTING,
    STAND,
    SWEEP,
    TEE_GOAL,
    Pallet,
    add_pallets,
    place_boxes,
    stack_pose,
)
from pnt_gym.cells.one_joint.parts import AITCH, BLOCK, SLOT, STEM, TEE
from pnt_gym.engine import mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.planning.one_joint.parameters import Arm
from tests.tools.one_joint import GUESS, arrival, is_dynamic_grasp, release

THROWS = [(p.name, BLOCK, p.goal) for p in SORTING] + [(part.name, part, goal) for part, goal in ASSEMBLY]
EVERY_THROW = pytest.mark.parametrize(("name", "part", "goal"), THROWS, ids=[name for name, *_ in THROWS])
number = st.floats(-1.0, 1.0)


def corners(box):
    """Of a box (5,), (4, 2)."""
    x, y, a, b, angle = box
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.array([x, y]) + np.array([[a, b], [-a, b], [-a, -b], [a, -b]]) @ turn.T


def distance(first, second):
    """Between two convex polygons (V, 2), 0 where they overlap: the nearest point of the origin in a - b."""
    difference = (first[:, None] - second).reshape(-1, 2)
    best, inside = np.inf, True
    for i in range(len(difference)):
        for j in range(len(difference)):
            side = difference[j] - difference[i]
            if i == j or not side.any():
                continue
            normal = np.array([-side[1], side[0]]) / np.hypot(*side)
            heights = (difference - difference[i]) @ normal
            if heights.min() < -1e-12:
                continue  # not a side of the hull
            inside &= -difference[i] @ normal >= 0.0
            share = np.clip(-difference[i] @ side / (side @ side), 0.0, 1.0)
            best = min(best, np.hypot(*(difference[i] + share * side)))
    return 0.0 if inside else best


@given(st.tuples(number, number, st.floats(0.0, 3.0), st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)))
def test_gaps_are_positive_exactly_where_boxes_are_apart_and_never_above_the_distance(numbers):
    x, y, size, one, two = numbers
    a, b = np.array([0.0, 0.0, 0.4, 0.1, one]), np.array([x, y, 0.2 + size / 10, 0.05, two])
    apart, gap = distance(corners(a), corners(b)), float(gaps(a, b))
    assert gap == pytest.approx(float(gaps(b, a)), abs=1e-12)
    assert gap <= apart + 1e-9
    if apart > 1e-9:
        assert gap > 0.0
    if gap > 1e-9:
        assert apart > 0.0


def test_the_engine_has_the_walls_where_the_geometry_says():
    spec = mujoco.MjSpec()
    pallets = (*SORTING, STAND)
    add_pallets(spec, pallets)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for pallet in pallets:
        for k, wall in enumerate(pallet.walls):
            geom = model.geom(f"{pallet.name}_{k}").id
            np.testing.assert_allclose(data.geom_xpos[geom][[0, 2]], wall[:2], atol=1e-12)
            turn = data.geom_xmat[geom].reshape(3, 3)
            np.testing.assert_allclose(turn[[0, 2], 0], [np.cos(wall[4]), np.sin(wall[4])], atol=1e-12)
            np.testing.assert_allclose(model.geom_size[geom][[0, 2]], wall[2:4], atol=1e-12)
        assert int(model.geom(f"{pallet.name}_bracket").contype[0]) == 0


@pytest.mark.parametrize("pallet", SORTING, ids=lambda pallet: pallet.name)
def test_a_pocket_bears_the_block_and_leaves_it_play(pallet):
    def gap(shift):
        moved = pallet.pose + shift * np.array([np.cos(pallet.pose[2]), np.sin(pallet.pose[2]), 0.0])
        boxes = place_boxes(np.array(BLOCK.boxes), moved)
        return float(gaps(boxes[:, None], pallet.walls).min())

    assert gap(0.0) == pytest.approx(0.0, abs=1e-12)
    assert gap(BACK_PLAY - 1e-6) == pytest.approx(0.0, abs=1e-12)
    assert gap(BACK_PLAY + 1e-3) == pytest.approx(-1e-3, abs=1e-9)
    assert gap(1e-6 - LIP_PLAY) == pytest.approx(0.0, abs=1e-12)
    assert gap(-1e-3 - LIP_PLAY) == pytest.approx(-1e-3, abs=1e-9)


def test_stand_h_and_t_stand_on_one_another_with_play_beside_the_stems():
    lower = place_boxes(np.array(AITCH.boxes), STAND.pose)
    upper = place_boxes(np.array(TEE.boxes), stack_pose(STAND.pose))
    assert float(gaps(lower[:, None], STAND.walls).min()) == pytest.approx(0.0, abs=1e-12)
    assert float(gaps(upper[:, None], lower).min()) == pytest.approx(0.0, abs=1e-12)
    along = np.array([np.cos(STAND.pose[2]), np.sin(STAND.pose[2]), 0.0])
    play = (SLOT - STEM) / 2
    for side in (-1.0, 1.0):
        for shift, touches in ((play - 1e-4, False), (play + 1e-4, True)):
            moved = place_boxes(np.array(TEE.boxes), stack_pose(STAND.pose + side * shift * along))
            assert (float(gaps(moved[:, None], lower).min()) < -5e-5) == touches
    np.testing.assert_allclose(TEE_GOAL[:3], stack_pose(STAND.pose), atol=1e-15)


def test_no_wall_is_in_the_sweep_of_the_arm():
    arm = Arm()
    for part in (BLOCK, TEE, AITCH):
        top = max(v for _, v in part.outline) + part.half_height
        assert np.hypot(arm.length / 2 + 0.003, top) < SWEEP
    for pallet in (*SORTING, STAND):
        edges = np.concatenate([corners(box) for box in pallet.walls])
        ends = np.stack([edges, np.concatenate([np.roll(corners(box), 1, axis=0) for box in pallet.walls])], axis=1)
        share = np.linspace(0.0, 1.0, 401)[:, None, None]
        points = ends[:, 0] * (1 - share) + ends[:, 1] * share
        assert float(np.hypot(points[..., 0], points[..., 1]).min()) > SWEEP


def test_pallets_do_not_touch_each_other():
    for i, one in enumerate(SORTING):
        for other in SORTING[i + 1 :]:
            assert float(gaps(one.walls[:, None], other.walls).min()) > 0.01


@EVERY_THROW
def test_every_goal_has_a_throw_within_the_limits(name, part, goal):
    u = release(goal, part.half_height, GUESS[name])
    arm = Arm()
    assert abs(u[0]) < np.pi / 2
    assert 0.0 < u[1] < arm.speed
    assert np.sqrt(u[2] ** 2 - part.half_height**2) + part.half_length < arm.length / 2
    assert is_dynamic_grasp(u, part, arm)


def test_the_assembly_arrives_along_the_slots():
    for part, goal in ASSEMBLY:
        state = arrival(release(goal, part.half_height, GUESS[part.name])[None], part.half_height)[0]
        fall, slot = np.arctan2(state[4], state[3]), state[2] - 3 * np.pi / 2
        assert np.degrees(fall - slot) == pytest.approx(0.0, abs=0.5)
        assert np.degrees(fall) == pytest.approx(-90.0, abs=10.0)


def test_the_sorting_throws_pass_the_other_pallets_and_the_assembly_its_own_stand_on_the_way_up():
    for pallet in SORTING:
        u = release(pallet.goal, BLOCK.half_height, GUESS[pallet.name])[None]
        assert clearance(u, BLOCK, [p for p in SORTING if p is not pallet])[0] > 0.015
    for part, goal in ASSEMBLY:
        rising = release(goal, part.half_height, GUESS[part.name])[None]
        rising[0, 3] -= 0.06
        assert clearance(rising, part, [STAND])[0] > 0.01


def test_clearance_is_that_of_a_fine_search_over_the_flight():
    generator = np.random.default_rng(3)
    low, high = np.array([[-0.2, 6.0, 0.15, 0.2], [1.2, 12.5, 0.28, 0.45]])
    u = generator.uniform(low, high, (60, 4))
    fine = [
        min(
            float(gaps(place_boxes(np.array(TEE.boxes), pose)[..., :, None, :], pallet.walls).min())
            for pallet in SORTING
            for pose in np.array_split(flight_poses(row[None], TEE.half_height, 20 * (SAMPLES - 1) + 1)[0], 4)
        )
        for row in u
    ]
    found = clearance(u, TEE, SORTING)
    assert (found >= np.array(fine) - 1e-12).all()
    np.testing.assert_allclose(found, fine, atol=1.5e-3)
    assert 5 < (found < 0.0).sum() < 55
    np.testing.assert_array_equal(clearance(u[7:8], TEE, SORTING), found[7:8])


def test_the_vertical_speed_decides_whether_the_other_pallets_are_passed():
    speeds = np.array([-2.6, -1.95, -1.7, -1.6, 1.0])
    clear = clear_vertical_speeds(SORTING[2], speeds, BLOCK, SORTING)
    # The first and the last have no throw; the second falls so steeply that it comes through the second pallet.
    np.testing.assert_array_equal(clear, [False, False, True, True, False])
    goal = np.array([*SORTING[2].goal[:3], -1.95])
    steep = release(goal, BLOCK.half_height, GUESS["pallet_3"])[None]
    assert clearance(steep, BLOCK, SORTING[1:2])[0] < 0.0 < clearance(steep, BLOCK, SORTING[:1])[0]
    alone = clear_vertical_speeds(SORTING[2], speeds, BLOCK, SORTING[2:])
    np.testing.assert_array_equal(alone, [False, True, True, True, False])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"goal": (0.0, np.nan, 0.0, 0.0)}, "finite goal"),
        ({"boxes": ()}, "at least one box"),
        ({"boxes": ((0.0, 0.0, 0.0, 0.01, 0.0),)}, "without size"),
        ({"depth": -1.0}, "without size"),
    ],
)
def test_an_impossible_pallet_is_refused(change, words):
    values = {"name": "odd", "goal": STAND.goal, "boxes": STAND.boxes} | change
    with pytest.raises(ConfigError, match=words):
        Pallet(**values)
