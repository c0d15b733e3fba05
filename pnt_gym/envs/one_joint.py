"""The one-joint thrower's tasks: a state in the air, three pallets, and two parts joined in a pallet."""

from __future__ import annotations

from typing import ClassVar, final

from pnt_gym.cells.base.config import Level
from pnt_gym.cells.one_joint.cell import OneJointCell
from pnt_gym.cells.one_joint.config import OneJointConfig, Task
from pnt_gym.cells.one_joint.observation import TABLE
from pnt_gym.envs.base import ThrowEnv
from pnt_gym.envs.vector import vector_form


class OneJointEnv(ThrowEnv, observes=TABLE):
    """Abstract: one arm. Subclasses say what is thrown where.

    ## Action Space

    `Box(-1, 1, (4,), float32)` in the mode `virtual_goal` (default); in `release_state` `Box(-1, 1, (3,), float32)`.
    Zero is the analytic planner. Values outside are clipped; a residual without a feasible plan is shortened to the
    longest feasible part of it and reported as `residual_clipped`.

    | Num | Action (`virtual_goal`) | Min | Max | At 1, with the default scale |
    |---|---|---|---|---|
    | 0 | goal along x | -1 | 1 | 0.20 m to the right |
    | 1 | goal along y | -1 | 1 | 0.20 m higher |
    | 2 | angle at the goal | -1 | 1 | 60 deg further anticlockwise |
    | 3 | vertical speed at the goal | -1 | 1 | 0.8 m/s more upward |

    The throw is planned again from scratch for the virtual goal, as in the paper. In `release_state` three numbers move
    the state at the release by raw amounts: 10 deg of the arm, 3 rad/s of its speed, 0.03 m of the object's radius.

    ## Observation Space

    `Box(-5, 5, (14,), float32)`: goal and nominal plan, as (value - centre) / scale, clipped. No hidden value enters.
    `pnt_gym.cells.one_joint.observation.decode` turns observations back into physical values.

    {observations}

    ## Rewards

    The sum of four terms, each in [0, 1] times its weight; `info` carries them as `reward_position`, `reward_angle`,
    `reward_speed` and `reward_success`. The errors are those of the simulated flight where it passes nearest to the
    goal.

    | Term | Formula | Weight |
    |---|---|---|
    | position | max(0, 1 - landing error / 0.1 m) | 1.0 |
    | angle | max(0, 1 - angle error / 30 deg) | 0.3 |
    | speed | max(0, 1 - speed error / 0.4 m/s) | 0.2 |
    | success | 1 if the throw did what its task asks | 0.5 |

    Weights and scales are the section `reward` of a level: the terms by name, of which 0 leaves one out, and
    `position_scale` [m], `angle_scale_deg` [deg] and `speed_scale` [m/s].

    ```yaml
    reward:
      success: 2.0           # more than the other three terms together, at most 1.5
      position_scale: 0.05   # landing error from which on that term is 0 [m]
    ```

    `info` also has these keys:

    | Key | Unit | Meaning |
    |---|---|---|
    | `is_success` | bool | the throw did what its task asks |
    | `landing_error` | m | distance of the simulated flight from its goal, where it passes nearest |
    | `angle_error`, `speed_error` | rad, m/s | errors of angle and vertical speed there |
    | `error_x`, `error_y` | m | errors of the place that the camera saw; controllers learn from these |
    | `error_phi`, `error_dy` | rad, m/s | errors of angle and vertical speed that the camera saw |
    | `residual_clipped` | bool | the residual was shortened to a feasible part |
    | `cycle_time` | s | until the object has arrived and the arm is back |
    | `peak_torque` | N m | largest torque of the motor |
    | `item`, `kind` | - | index of the kind that was thrown, and of the coming kind |
    | `target_x`, `target_y` | m | place of the goal |

    ## Arguments

    | Parameter | Type | Default | Description |
    |---|---|---|---|
    | `level` | str, path or mapping | `"nominal"` | shipped level (contact, ideal, late, nominal, paper), yours |
    | `action_mode` | str or None | None | `virtual_goal` (None) or `release_state` |
    {arguments}

    Item and target are the same here, the kind of throw: `pallet_1` to `pallet_3` of `OneJointSort-v0`, the level's
    own goals of `OneJointThrow-v0` (where they are drawn, all are a `goal`), and `aitch`, with which
    `OneJointAssembly-v0` always begins.

    ## Version History

    * v0: first version.
    """

    task: ClassVar[Task]

    @classmethod
    def load_config(cls, level: Level) -> OneJointConfig:
        """The config of a level."""
        return OneJointConfig.load(level, task=cls.task)

    @classmethod
    def make_cell(cls, level: Level, count: int, threads: int) -> OneJointCell:
        """`count` cells of a level."""
        return OneJointCell(cls.load_config(level), count, threads)


@final
class OneJointThrowEnv(OneJointEnv):
    """A plate on one motor throws a block so that it passes a state: place, angle and vertical speed.

    ## Description

    The block lies on the arm. The arm turns anticlockwise from rest, accelerating so that the block stays put, and
    brakes as hard as it can: the block leaves and turns on as it flies. Four numbers at the release (angle and speed of
    the arm, radius of the block, flight time) fix four of the goal: x, y, phi and the vertical speed dy. The planner of
    Miyashita et al. finds the four numbers, and a motion of the arm that keeps its margins, as if the block came
    free at once and met no air. The real block lies a little too far out and comes free late, the real arm is heavier
    and rubs: the action corrects for that.

    One step is one throw: plan, references, one rollout of the physics, outcome. With the level `contact` the stoppers
    that hold the block stay physical: they push the block while the arm brakes and take half of its spin. No release
    reaches the usual goals then; there are eight others, and the vertical speed is left free.

    ## Rewards

    Success: all errors are within the tolerance, 5 mm, 2 deg and 0.05 m/s by default.

    ## Starting State

    A goal drawn uniformly from a box in x, y, phi and dy, again until it is out of the arm's sweep and in its reach,
    with a reserve for what a late release takes; the level `paper` has the one goal of the paper's experiment. The arm
    rests where the plan begins, the block on it.

    ## Episode End

    Termination after the one throw. The observation returned with it is that of the next episode's throw.
    """

    task: ClassVar[Task] = "throw"


OneJointThrowVectorEnv = vector_form(OneJointThrowEnv)


@final
class OneJointSortEnv(OneJointEnv):
    """Three pallets stand beside one arm; a block is thrown into the one that is asked for.

    ## Description

    The pallets are concave pockets at the goals, turned so that the block arrives in them with its angle. A different
    vertical speed at each goal keeps the flights clear of the other pallets, as Miyashita et al. sort by throwing.
    Arm, block, planner and what the planner does not know are those of `OneJointThrow-v0`. The simulation goes on until
    the block lies still.

    ## Rewards

    Success: the block lies at rest in its pallet (`in_pallet`) and touched no other (`touched_other`).

    ## Starting State

    One of the three pallets, drawn with equal chances; all are empty. The arm rests where the plan begins, the block on
    it.

    ## Episode End

    Termination after the one throw. The observation returned with it is that of the next episode's throw.
    """

    task: ClassVar[Task] = "sort"


OneJointSortVectorEnv = vector_form(OneJointSortEnv)


@final
class OneJointAssemblyEnv(OneJointEnv):
    """Two parts are thrown one after the other so that they join: an H onto a fixed stand, then a T onto the H.

    ## Description

    The parts fall almost vertically onto their goals: the vertical speed is chosen so that the parts have hardly any
    horizontal speed left. The second part is aimed at the first one as it lies. Arm, planner and what the planner
    does not know are those of `OneJointThrow-v0`; the parts differ in mass, inertia and height.

    ## Rewards

    Success: the part lies at rest on its stand, or joined to the part before (`in_pallet`), and the second touched no
    stand (`touched_other`); `is_complete` says that both are in place.

    ## Starting State

    Nothing on the stand, the H on the arm, which rests where the plan begins.

    ## Episode End

    Termination after the second throw, or after the first if the part is not in place: there is nothing to put the
    second on. The observation returned with it is that of the next episode's first throw.
    """

    task: ClassVar[Task] = "assembly"


OneJointAssemblyVectorEnv = vector_form(OneJointAssemblyEnv)
