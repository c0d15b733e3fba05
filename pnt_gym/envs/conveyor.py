"""The conveyor tasks: a shift at the moving belt, and the same throws as a contextual bandit."""

from __future__ import annotations

from typing import ClassVar, final

from pnt_gym.cells.base.config import Level
from pnt_gym.cells.conveyor.cell import ConveyorCell, Picks
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.observation import SHIFT_TABLE, TABLE
from pnt_gym.envs.base import ThrowEnv
from pnt_gym.envs.vector import vector_form


class ConveyorEnv(ThrowEnv, observes=TABLE):
    """Abstract: one conveyor cell. Subclasses say where picks come from.

    ## Action Space

    `Box(-1, 1, (2,), float32)` in the modes `release_point` (default) and `virtual_goal`; in `release_xyz` and
    `fixed_throw` `Box(-1, 1, (3,), float32)`. Zero is the analytic planner, except in `fixed_throw`. Values outside are
    clipped; a residual without a feasible plan is shortened to the longest feasible part of it and reported as
    `residual_clipped`.

    | Num | Action (`release_point`) | Min | Max | At 1, with the default scale |
    |---|---|---|---|---|
    | 0 | release point along the throw line | -1 | 1 | drag-free landing 0.20 m farther |
    | 1 | release point sideways, at the planned elevation | -1 | 1 | drag-free landing 0.06 m to the left |

    In `virtual_goal` the same two numbers move the target, and the throw is planned again from scratch (it can jump
    between the planner's flat and steep solutions). In `release_xyz` three numbers move the release point by raw
    metres: 0.12 along, 0.02 sideways, 0.015 up. Where a level's `planner` puts objects down instead of throwing them,
    the first two modes shift the place where the hand lets go, and `release_xyz` shifts the hand. With `planner: auto`
    there is a fourth mode, `throw_or_place`, `Box(-1, 1, (3,), float32)`: `release_point` with a third number. Above
    1/2 the third number reverses the rule: a throw becomes a place, and a place a throw.

    The mode `fixed_throw` shows what the analytic planner is worth: an action is the release itself, not a correction.
    The numbers are the throw's bearing, 60 degrees to the left at 1; the logarithm of the way from the pick to the
    release, 0.0125 to 0.80 m; and the height of the release above the pick, from none to the ceiling. Zero is the same
    throw for all picks: straight across the belt, 0.10 m far. A throw that would carry its object into
    a bin's wall is shortened like one that leaves the workspace. The speed follows from the way, as in every throw.
    Nothing else depends on the target. The entries of the observation that tell of the planner's throw are 0:
    `release_speed`, `elevation`, `release_distance`, `flight_time`, and on PnTAdapt-v0 the shift of the last throw. The
    mode exists where hands move straight to the release, that is with `planner: straight` and `straight_flying`.

    ## Observation Space

    `Box(-5, 5, ({entries},), float32)`: measurements of the cell, as (value - centre) / scale, clipped. No hidden value
    enters. `pnt_gym.cells.conveyor.observation.decode` turns observations back into physical values.

    {observations}

    ## Rewards

    The sum of three terms, each in [0, 1] times its weight; `info` carries them as `reward_landing`, `reward_success`
    and `reward_time`.

    | Term | Formula | Weight |
    |---|---|---|
    | landing | max(0, 1 - landing error / 0.25 m) | 1.0 |
    | success | 1 if the object crossed the opening and lies in the bin | 0.1 |
    | time | max(0, 1 - cycle time / 3 s) | 0.1 |

    Weights and scales are the section `reward` of a level: `landing`, `success` and `time`, of which 0 leaves a term
    out, `landing_scale` [m] and `time_scale` [s].

    ```yaml
    reward:
      success: 1.0          # counts as much as landing, whose weight stays 1.0
      landing_scale: 0.10   # landing error from which on that term is 0 [m]
    ```

    At the end of an episode of several throws, `info["episode_success"]` is the share of them that succeeded.

    `info` also has these keys. Landings are NaN where the cup did not seal.

    | Key | Unit | Meaning |
    |---|---|---|
    | `is_success` | bool | the object crossed the opening and lies in the bin |
    | `landing_error` | m | distance of the landing from the target |
    | `landing_along`, `landing_across` | m | landing from the target, along the throw and to its left |
    | `in_opening`, `in_bin` | bool | the landing is in the opening; the object lies in the bin at the end |
    | `rim` | bool | in the opening but not in the bin |
    | `picked` | bool | the cup sealed |
    | `dropped` | bool | the cup lost the object on the way to the release |
    | `recontact` | bool | the cup touched the object after the release |
    | `grip_margin` | - | times the load that the cup could hold, at the worst moment until the release |
    | `slip` | m | way of the belt under the cup during the dwell |
    | `disturbed` | bool | the object swept through a neighbour on the belt |
    | `placed` | bool | the object was carried to its bin, not thrown |
    | `passed` | - | objects given up since the last throw, or since the episode began; 0 without a belt |
    | `residual_clipped` | bool | the residual was shortened to a feasible part |
    | `cycle_time`, `wait_time` | s | from one pick to the next; the part in which the hand waits above the belt |
    | `peak_torque` | N m | largest torque of a motor |
    | `energy` | J | positive work of the motors from lift to lift, without recuperation |
    | `item`, `true_kind` | - | indices of the class that the sensors see in the thrown object, and of its true class |
    | `kind` | - | index of the seen class of the object now under the cup, in the level's `items` |
    | `bin` | - | index of the bin of this throw |
    | `target_x`, `target_y` | m | centre of the bin's opening |
    | `bin_depth` | m | free depth of the bin above its filling |
    | `ended_in` | - | index of the bin in which the object lies at the end, -1 for none |
    | `belongs` | bool | that bin takes the true class of the object |
    | `sorted` | bool | a success in a bin that takes the true class |

    ## Arguments

    | Parameter | Type | Default | Description |
    |---|---|---|---|
    | `level` | str, path, mapping or ConveyorConfig | `"nominal"` | a shipped level, or one of your own |
    | `action_mode` | str or None | None | `release_point` (None), `release_xyz`, `virtual_goal` or `fixed_throw` |
    {arguments}

    Items are the level's `items`, targets its fixed bins, in `nominal` `inside` and `outside`; a bin that is drawn for
    every throw has no name. On the belt the first object is met where it enters the window, from where some bins may
    be out of reach. A request that no throw meets in 4096 draws is refused.

    ## Version History

    * v0: first version.
    """

    picks: ClassVar[Picks]
    feedback: ClassVar[bool] = False

    @classmethod
    def load_config(cls, level: Level) -> ConveyorConfig:
        """The config of a level."""
        return ConveyorConfig.load(level)

    @classmethod
    def make_cell(cls, level: Level, count: int, threads: int) -> ConveyorCell:
        """`count` cells of a level."""
        return ConveyorCell(cls.load_config(level), count, cls.picks, threads, cls.feedback)


@final
class PnTConveyorEnv(ConveyorEnv):
    """A shift at the conveyor: a parallel robot throws objects off a moving belt into bins.

    ## Description

    Objects ride a belt. A suction cup takes one, the hand accelerates along a straight line, lets go, runs on for a
    moment, brakes, and meets the next object. The time-optimal planner of Hassan et al. 2022 gives every release as
    if the object were a point at the cup that flies without drag and is let go at once. The real object hangs below
    the cup, off its axis, swings under a lip that yields, leaves late by the decay of the vacuum, and is slowed by the
    air. The action corrects these errors. No action corrects a cup that fails to seal, or that drops a heavy object.

    One step is one throw: plan, references, one rollout of the physics, outcome. A step covers the throw, the
    follow-through, the return and the vertical approach to the next object. The next object is chosen on the belt while
    the hand returns. Candidates are the objects that the hand can meet inside the window and throw, if possible without
    touching neighbours; the level's `dispatch` rule takes the best candidate. The dwell at the pick, in which the hand
    rides with the belt, is counted, not simulated.

    ## Starting State

    Objects lie 0.02 to 0.18 m apart upstream of the window, from edge to edge; kinds, sizes, masses, yaw and lane are
    drawn from the level. The first object is under the cup, the bins are empty.

    ## Episode End

    Truncation after `picks_per_shift` throws (50). There is no termination: a missed object costs its reward only.
    """

    picks: ClassVar[Picks] = "belt"


PnTConveyorVectorEnv = vector_form(PnTConveyorEnv)


@final
class PnTAdaptEnv(ConveyorEnv, observes=SHIFT_TABLE):
    """A shift in a cell that nobody measured: a lesson from an early throw helps all later throws.

    ## Description

    The cell is that of PnTConveyor-v0, with changes that no sensor measures, as the level's section `drift` says: the
    valve releases late or early, the camera is displaced along and across the belt, the belt's encoder is wrong by a
    share, air moves through the cell. Every shift of `picks_per_shift` picks has drifts of its own, constant or
    changing. Drifts are drawn from a separate generator, so the objects on the belt are those of PnTConveyor-v0. Every
    drift is centred at zero and scales with the mismatch. A camera over the bins sees, with noise, where each object
    comes down. The observation of the next pick includes this landing, the offset that the last action asked for, and
    the direction of the last throw. A few hidden numbers explain all errors of a shift; a throw that explores pays for
    its own error.

    The levels `cells` and `cells_far` have another cell in every shift, as the level's section `cells` says: valve,
    vacuum, blown air, lip, drag, restitution, seals, and the scales of camera and encoder are drawn when the shift
    begins, from a separate generator.

    On levels with drift, judge by the landing error and its share within 30 mm: at the openings of `waste`, 120 mm and
    more, drift hardly shows in the success rate. On `cells`, judge by the sorted objects per minute.

    ## Observation Space

    The first 26 entries are those of PnTConveyor-v0, the same in a cell that does not drift. The other eight describe
    the last throw: the landing along that throw and to its left, as seen by the camera over the bins. The level's
    section `feedback` gives the camera's noise, the share of landings that the camera misses, and its view. A failed
    pick, a dropped object and a landing out of view are unseen.

    ## Rewards

    `info` also has `seen_along` and `seen_across` [m], the landing as the camera over the bins saw it (NaN where the
    camera saw nothing), beside the true `landing_along` and `landing_across`; and `pick_in_shift`, 0 for the first.

    ## Starting State

    As PnTConveyor-v0; the entries of the last throw are empty.

    ## Episode End

    As PnTConveyor-v0: a shift.

    ## Arguments

    `gymnasium.make` sets `level` to `"day"` where none is given; the levels `steps` and `drift_mix` have other drifts,
    `day_far`, `steps_far` and `drift_mix_far` twice as much. `cells` has another cell in every shift, `cells_far` cells
    outside of its ranges. Any other level of PnTConveyor-v0 is one without drift.
    """

    picks: ClassVar[Picks] = "belt"
    feedback: ClassVar[bool] = True


PnTAdaptVectorEnv = vector_form(PnTAdaptEnv)


@final
class PnTReleaseEnv(ConveyorEnv):
    """One throw per episode: the release correction as a contextual bandit.

    ## Description

    The cell of PnTConveyor-v0 without its belt traffic: every episode draws an object, a pick, a speed setting, a bin
    and what lies in it, and one action decides the throw. Contexts depend on the seed alone and never on actions, so
    throws of two policies on equal seeds are exactly paired. The cycle time is that of the throw and the return to an
    object standing somewhere in the pick window.

    ## Starting State

    Object, pick point (x in [-0.30, 0.30] m, less what the hand rides before the lift, y in the lanes of the belt),
    speed setting and bin are drawn from the level, again if the throw or one 0.10 m longer or shorter would leave the
    workspace.

    ## Episode End

    Termination after the one throw. The observation returned with it is that of the next episode's pick.
    """

    picks: ClassVar[Picks] = "independent"


PnTReleaseVectorEnv = vector_form(PnTReleaseEnv)
