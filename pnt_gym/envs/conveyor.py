"""The conveyor tasks: a shift at the moving belt, and the same throws as a contextual bandit."""

from __future__ import annotations

from typing import ClassVar, final

from pnt_gym.cells.base.config import Level, describes_a_cell
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.cell import ConveyorCell, Picks
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.envs.base import ThrowEnv, ThrowVectorEnv


def _core(level: Level, picks: Picks, action_mode: str, count: int, threads: int) -> Core:
    with describes_a_cell():
        return Core(ConveyorCell(ConveyorConfig.load(level), count, picks, threads), action_mode)


class ConveyorEnv(ThrowEnv):
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
    metres: 0.12 along, 0.02 sideways, 0.015 up.

    ## Observation Space

    `Box(-5, 5, (26,), float32)`: what a cell measures, as (value - centre) / scale, clipped. Nothing hidden enters.
    `pnt_gym.cells.conveyor.observation.decode` turns observations back into physical values.

    | Num | Observation | Min | Max | Centre | Scale | Unit | Meaning |
    |---|---|---|---|---|---|---|---|
    | 0 | pick_x | -5 | 5 | 0.0 | 0.30 | m | pick point, cup centre |
    | 1 | pick_y | -5 | 5 | -0.33 | 0.15 | m | pick point, cup centre |
    | 2 | target_x | -5 | 5 | 0.0 | 0.40 | m | centre of the bin's opening |
    | 3 | target_y | -5 | 5 | 0.50 | 0.25 | m | centre of the bin's opening |
    | 4 | distance | -5 | 5 | 0.85 | 0.25 | m | horizontal distance from pick to target |
    | 5 | opening | -5 | 5 | 0.15 | 0.05 | m | smaller side of the opening |
    | 6 | belt_speed | -5 | 5 | 0.25 | 0.25 | m/s | nominal belt speed |
    | 7 | release_speed | -5 | 5 | 2.2 | 0.5 | m/s | of the nominal plan |
    | 8 | elevation | -5 | 5 | 0.45 | 0.30 | rad | of the nominal plan |
    | 9 | release_distance | -5 | 5 | 0.35 | 0.20 | m | pick to release, of the nominal plan |
    | 10 | flight_time | -5 | 5 | 0.28 | 0.10 | s | of the nominal plan, without drag |
    | 11 | length | -5 | 5 | 0.12 | 0.06 | m | measured, along the object |
    | 12 | width | -5 | 5 | 0.07 | 0.03 | m | measured, across the object |
    | 13 | height | -5 | 5 | 0.05 | 0.03 | m | measured |
    | 14 | is_ellipsoid | -5 | 5 | 0.5 | 0.5 | - | shape, one-hot |
    | 15 | is_cylinder | -5 | 5 | 0.5 | 0.5 | - | shape, one-hot |
    | 16 | is_box | -5 | 5 | 0.5 | 0.5 | - | shape, one-hot |
    | 17 | ln_mass | -5 | 5 | -4.2 | 0.8 | ln kg | logarithm of the measured mass |
    | 18 | ln_seal | -5 | 5 | 2.4 | 0.6 | ln N | logarithm of the measured vacuum force F0 |
    | 19 | ln_grip_ratio | -5 | 5 | 4.3 | 0.8 | - | ln(F0 / (m g)): release delay is linear in it |
    | 20 | frontal_area_per_mass | -5 | 5 | 0.35 | 0.20 | m2/kg | area facing the throw over mass: drag |
    | 21 | plan_area_per_mass | -5 | 5 | 0.50 | 0.30 | m2/kg | horizontal area over mass: lift |
    | 22 | cos_2yaw | -5 | 5 | 0.0 | 1.0 | - | yaw of the object against the throw, doubled |
    | 23 | sin_2yaw | -5 | 5 | 0.0 | 1.0 | - | yaw of the object against the throw, doubled |
    | 24 | grasp_along | -5 | 5 | 0.0 | 0.010 | m | measured centre of mass from the cup, along the throw |
    | 25 | grasp_across | -5 | 5 | 0.0 | 0.010 | m | measured centre of mass from the cup, left of the throw |

    ## Rewards

    The sum of three terms, each in [0, 1] times its weight; `info` carries them as `reward_landing`, `reward_success`
    and `reward_time`.

    | Term | Formula | Weight |
    |---|---|---|
    | landing | max(0, 1 - landing error / 0.25 m) | 1.0 |
    | success | 1 if the object crossed the opening and lies in the bin | 0.1 |
    | time | max(0, 1 - cycle time / 3 s) | 0.1 |

    `info` also has `is_success`, `landing_error`, `landing_along`, `landing_across` [m], `cycle_time`,
    `wait_time` [s], `in_opening`, `in_bin`, `rim` (in the opening but not in the bin), `recontact` (the cup touched
    the object after the release), `residual_clipped`, `peak_torque` [N m], `item` and `bin` (indices of what was thrown
    where), `target_x`, `target_y`, and `kind`: the index, into the level's `items`, of the object now under the cup.

    ## Arguments

    | Parameter | Type | Default | Description |
    |---|---|---|---|
    | `level` | str, path, mapping or ConveyorConfig | `"nominal"` | a shipped level, or one of your own |
    | `action_mode` | str | `"release_point"` | `release_point`, `release_xyz` or `virtual_goal` |
    | `threads` | int | 1 (vector: 2) | physics threads; results do not depend on it |
    | `render_mode` | str or None | None | `rgb_array`: coming pick, `rgb_array_list`: last throw, `human` |
    | `num_envs` | int | 1 | only of the vector form, `gymnasium.make_vec` |

    ## Version History

    * v0: first version.
    """

    picks: ClassVar[Picks]

    def __init__(
        self,
        level: Level = "nominal",
        action_mode: str = "release_point",
        threads: int = 1,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(_core(level, self.picks, action_mode, 1, threads), render_mode)


class ConveyorVectorEnv(ThrowVectorEnv):
    """Abstract: N conveyor cells. Subclasses say where picks come from."""

    picks: ClassVar[Picks]

    def __init__(
        self,
        num_envs: int = 1,
        level: Level = "nominal",
        action_mode: str = "release_point",
        threads: int = 2,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(_core(level, self.picks, action_mode, num_envs, threads), render_mode)


@final
class PnTConveyorEnv(ConveyorEnv):
    """A shift at the conveyor: a parallel robot throws objects off a moving belt into bins.

    ## Description

    Objects ride a belt. A suction cup takes one, the hand accelerates along a straight line, lets go, runs on for a
    moment, brakes, and meets the next object. The time-optimal planner of Hassan et al. 2022 gives every throw as
    if the object were a point at the cup that flies without drag and is let go at once. The real object hangs below
    the cup, off its axis, leaves late by the decay of the vacuum, and is slowed by the air: the action corrects for
    that.

    One step is one throw: plan, references, one rollout of the physics, outcome. It covers the throw, the
    follow-through, the return and the vertical approach to the next object, which is chosen on the belt while the
    hand returns: the first one that can be met inside the window and thrown. The dwell at the pick is counted, not
    simulated.

    ## Starting State

    Objects lie 0.10 to 0.30 m apart upstream of the window; kinds, sizes, masses, yaw and lane are drawn from the
    level. The first object is under the cup, the hand at rest.

    ## Episode End

    Truncation after `picks_per_shift` throws (50). There is no termination: a missed object costs its reward only.
    """

    picks: ClassVar[Picks] = "belt"


@final
class PnTConveyorVectorEnv(ConveyorVectorEnv):
    """N cells of `PnTConveyorEnv` on one batch of simulations; row i of seed s is the single form of seed s + i."""

    picks: ClassVar[Picks] = "belt"


@final
class PnTReleaseEnv(ConveyorEnv):
    """One throw per episode: the release correction as a contextual bandit.

    ## Description

    The cell of PnTConveyor-v0 without its belt traffic: every episode draws an object, a pick, a speed setting and a
    bin, and one action decides the throw. Contexts depend on the seed alone and never on actions, so throws of two
    policies on equal seeds are exactly paired. The cycle time is that of the throw and the return to an object standing
    somewhere in the pick window.

    ## Starting State

    Object, pick point (x in [-0.30, 0.30] m, y in the lanes of the belt), speed setting and bin are drawn from the
    level, again if the throw or one 0.10 m longer or shorter would leave the workspace.

    ## Episode End

    Termination after the one throw. The observation returned with it is that of the next episode's pick.
    """

    picks: ClassVar[Picks] = "independent"


@final
class PnTReleaseVectorEnv(ConveyorVectorEnv):
    """N cells of `PnTReleaseEnv` on one batch of simulations; row i of seed s is the single form of seed s + i."""

    picks: ClassVar[Picks] = "independent"
