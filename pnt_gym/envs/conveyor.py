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

    `Box(-1, 1, (2,), float32)` in the modes `release_point` (default) and `virtual_goal`; in `release_xyz` `Box(-1,
    1, (3,), float32)`. Zero is the analytic planner. Values outside are clipped; a residual without a feasible plan
    is shortened to the longest feasible part of it and reported as `residual_clipped`.

    | Num | Action (`release_point`) | Min | Max | At 1, with the default scale |
    |---|---|---|---|---|
    | 0 | release point along the throw line | -1 | 1 | drag-free landing 0.20 m farther |
    | 1 | release point sideways, at the planned elevation | -1 | 1 | drag-free landing 0.06 m to the left |

    In `virtual_goal` the same two numbers move the target, and the throw is planned again from scratch (it can jump
    between the planner's flat and steep solutions). In `release_xyz` three numbers move the release point by raw
    metres: 0.12 along, 0.02 sideways, 0.015 up. Where a level's `planner` puts objects down instead of throwing them,
    the first two modes shift the place where the hand lets go, and `release_xyz` shifts the hand. Where it is `auto`
    there is a fourth mode, `throw_or_place`, `Box(-1, 1, (3,), float32)`: as `release_point`, and with a third number
    above 1/2 an object is put down that would be thrown, or the other way round.

    ## Observation Space

    `Box(-5, 5, ({entries},), float32)`: what a cell measures, as (value - centre) / scale, clipped. Nothing hidden
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

    `info` also has `is_success`, `landing_error`, `landing_along`, `landing_across` [m], `cycle_time`, `wait_time`
    [s], `in_opening`, `in_bin`, `rim` (in the opening but not in the bin), `recontact` (the cup touched the object
    after the release), `picked` (the cup sealed; else landings are NaN), `dropped` (lost on the way to the
    release), `grip_margin` (how many times the load the cup could hold, at the worst moment until then), `slip` (how
    far the belt carries it on under the cup during the dwell [m]), `passed` (objects on the belt that were let go since
    the throw before, or since the episode began; 0 without a belt), `disturbed` (it swept through another object on the
    belt), `placed` (put down at its bin, not thrown), `residual_clipped`, `peak_torque` [N m], `energy`
    (positive work of the motors from lift to lift, without recuperation) [J], `item` and `bin` (indices of what was
    seen and thrown where), `true_kind` (index of what it truly is), `target_x`, `target_y`, `bin_depth` (of its bin
    above what lies in it) [m], `ended_in` (index of the bin in which the object lies at the end, -1 in none), `belongs`
    (that bin takes it), `sorted` (a success that belongs there), and `kind`: the index, into the level's `items`, of
    what the object now under the cup is seen as.

    ## Arguments

    | Parameter | Type | Default | Description |
    |---|---|---|---|
    | `level` | str, path, mapping or ConveyorConfig | `"nominal"` | a shipped level, or one of your own |
    | `action_mode` | str or None | None | `release_point` (None), `release_xyz` or `virtual_goal` |
    {arguments}

    Items are the level's `items`, targets its fixed bins, in `nominal` `inside` and `outside`; a bin that is drawn for
    every throw has no name. On the belt the first object is met where it enters the window, from where some bins may
    be out of reach. What does not come in 4096 draws is refused.

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
    moment, brakes, and meets the next object. The time-optimal planner of Hassan et al. 2022 gives every throw as
    if the object were a point at the cup that flies without drag and is let go at once. The real object hangs below
    the cup, off its axis, swings under a lip that yields, leaves late by the decay of the vacuum, and is slowed by the
    air: the action corrects for that. It does not for a cup that fails to seal or loses what is more than it can hold.

    One step is one throw: plan, references, one rollout of the physics, outcome. It covers the throw, the
    follow-through, the return and the vertical approach to the next object, which is chosen on the belt while the
    hand returns: of those that can be met inside the window and thrown, if possible without touching others, the best
    one by the level's `dispatch` rule. The dwell at the pick, in which the hand rides with the belt, is counted, not
    simulated.

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
    """A shift in a cell that drifts: what an early throw teaches pays later.

    ## Description

    The cell of PnTConveyor-v0, in which things change that no sensor tells, as the level's section `drift` says: the
    valve releases late or early, the camera is off along and across the belt, the belt's encoder is off by a share, air
    moves through the cell. Every shift of `picks_per_shift` picks has values of its own, constant or changing on the
    way, drawn from a generator of their own: the objects on the belt are those of PnTConveyor-v0. All are centred at
    zero and scale with the mismatch. A camera over the bins sees where each object came down, with noise: the
    observation of the next pick tells it, beside what was asked for and where that throw went. From the first throw
    to the last the same few numbers are to be found out, and a throw that tries something pays for it itself.

    Judge by the landing error and its share within 30 mm: at the openings of `waste`, 120 mm and more, drift hardly
    shows in the success rate.

    ## Observation Space

    The first 26 entries are those of PnTConveyor-v0, the same in a cell that does not drift. The other eight tell of
    the throw before: where it came down, along it and to its left, by a camera with the noise, the blind share and
    the view of the level's section `feedback`. What was not picked, was lost on the way or came down out of its view is
    unseen.

    ## Rewards

    `info` also has `seen_along` and `seen_across` [m], what the bin's camera saw where `landing_along` and
    `landing_across` are true (NaN where it saw nothing), and `pick_in_shift`, 0 for the first.

    ## Starting State

    As PnTConveyor-v0; nothing is known of a throw before.

    ## Episode End

    As PnTConveyor-v0: a shift.

    ## Arguments

    `gymnasium.make` sets `level` to `"day"` where none is given; `steps` and `drift_mix` drift otherwise, `day_far`,
    `steps_far` and `drift_mix_far` twice as much. Any other level of PnTConveyor-v0 is one without drift.
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
