"""The gripper robot's task: pick by friction, toss by opening in motion."""

from __future__ import annotations

from typing import final

from pnt_gym.cells.base.config import Level
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.observation import TABLE
from pnt_gym.envs.base import ThrowEnv
from pnt_gym.envs.vector import vector_form


@final
class GripperTossEnv(ThrowEnv, observes=TABLE):
    """A parallel robot with a gripper built into its platform picks small objects and tosses them into a tray.

    ## Description

    The four motors of Leveziel's robot move the platform and open and close its two geared halves. A cork, a bottle
    cap or a rubber block is gripped by friction in real contact, lifted, carried onto a straight line and let go in
    motion: the claws open while the robot moves. Opening takes time, and the object comes free during that time, at a
    moment that differs between objects. The planner knows neither this moment, nor the air, the object's true size and
    friction, or the lag of the servos. The action corrects the place of the release, and the moment at which the claws
    begin to open.

    One step is one throw: grip, lift, move, toss, flight, landing, all in one rollout of the physics. With the level
    `drop` the robot comes to rest above the tray before it opens, as in the paper.

    With the level `belt` a robot of industrial size, 4.1 times the prototype, sorts paper balls, yoghurt cups and
    crushed cans from the belt of the conveyor cell `waste`. The claws close while the platform moves along with the
    object, the lift begins at the belt's velocity, and the bins stand beyond the robot's reach. The belt runs a little
    faster or slower than the planner knows, so objects are some millimetres ahead or behind. Any other size is a YAML
    file away: `robot` scales lengths and masses or names them one by one, `conveyor` names the conveyor cell.

    ## Action Space

    `Box(-1, 1, (3,), float32)` in the mode `release` (default); in `release_point` `Box(-1, 1, (2,), float32)`. Zero is
    the analytic planner. Values outside are clipped; a residual without a feasible plan is shortened to a feasible part
    of it and reported as `residual_clipped`.

    | Num | Action (`release`) | Min | Max | At 1, with the default scale |
    |---|---|---|---|---|
    | 0 | release point along the throw | -1 | 1 | 0.030 m farther, and so the landing |
    | 1 | release point to the left | -1 | 1 | 0.015 m, and so the landing |
    | 2 | moment at which the claws begin to open | -1 | 1 | 0.050 s later |

    The mode `release_point` has the first two numbers; the claws open when the planner says. A level may scale the
    action otherwise: with `belt` 1 stands for 0.12 m, 0.04 m and 0.05 s.

    ## Observation Space

    `Box(-5, 5, (15,), float32)`: the object as seen and the nominal plan, as (value - centre) / scale, clipped. No
    hidden value enters. A level for a robot of another size has centres and scales of its own, as `belt` does.
    `pnt_gym.cells.gripper.observation.decode` turns observations back into physical values, given the level's
    `feature_table` where the level has one.

    {observations}

    ## Rewards

    The sum of three terms, each in [0, 1] times its weight; `info` carries them as `reward_landing`, `reward_success`
    and `reward_time`.

    | Term | Formula | Weight |
    |---|---|---|
    | landing | max(0, 1 - landing error / 0.06 m), with `belt` 0.2 m | 1.0 |
    | success | 1 if the object crossed the opening and lies in its compartment | 0.5 |
    | time | max(0, 1 - cycle time / 2 s) | 0.1 |

    Weights and scales are the section `reward` of a level: `landing`, `success` and `time`, of which 0 leaves a term
    out, `landing_scale` [m] and `time_scale` [s].

    ```yaml
    reward:
      time: 0.0             # speed is not rewarded
      landing_scale: 0.03   # landing error from which on that term is 0 [m]
    ```

    `info` also has these keys:

    | Key | Unit | Meaning |
    |---|---|---|
    | `is_success` | bool | the object crossed the opening and lies in its compartment |
    | `landing_error` | m | distance of the landing from the target |
    | `landing_along`, `landing_across` | m | landing from the target, along the throw and to its left |
    | `in_opening`, `in_bin` | bool | the landing is in the opening; the object lies in the compartment at the end |
    | `rim` | bool | in the opening but not in the compartment |
    | `picked` | bool | the claws held the object until they were told to open |
    | `slip` | m | way of the object along the pads |
    | `recontact` | bool | a pad met the object again after the release |
    | `release_delay` | s | from the planned moment until the object came free |
    | `residual_clipped` | bool | the residual was shortened to a feasible part |
    | `cycle_time` | s | from one pick to the next |
    | `peak_torque` | N m | largest torque of a motor |
    | `energy` | J | positive work of the motors, without the way back and without recuperation |
    | `item`, `kind` | - | index of the thrown object, and of the coming object |
    | `target_x`, `target_y` | m | centre of the compartment's opening |

    ## Starting State

    One of the three objects, drawn with equal chances, at a place drawn from the table's pick area, turned and sized a
    little differently each time; the claws are open above it.

    ## Episode End

    Termination after the one throw. The observation returned with it is that of the next episode's throw.

    ## Arguments

    | Parameter | Type | Default | Description |
    |---|---|---|---|
    | `level` | str, path or mapping | `"nominal"` | shipped level (ideal, nominal, patient, late, drop, belt), yours |
    | `action_mode` | str or None | None | `release` (None) or `release_point` |
    {arguments}

    Items are the level's `items`. Each item has its own compartment, and a target has the name of the item that belongs
    there.

    ## Version History

    * v0: first version.
    """

    @classmethod
    def load_config(cls, level: Level) -> GripperConfig:
        """The config of a level."""
        return GripperConfig.load(level)

    @classmethod
    def make_cell(cls, level: Level, count: int, threads: int) -> GripperCell:
        """`count` cells of a level."""
        return GripperCell(cls.load_config(level), count, threads)


GripperTossVectorEnv = vector_form(GripperTossEnv)
