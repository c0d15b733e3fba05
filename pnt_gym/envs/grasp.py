"""The task of seeing, grasping and throwing."""

from __future__ import annotations

from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.config import Level, describes_a_cell
from pnt_gym.cells.grasp.action import MODE
from pnt_gym.cells.grasp.config import PIXELS, GraspConfig
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.images import pixel_places
from pnt_gym.cells.grasp.observation import TABLE
from pnt_gym.envs.base import CoreEnv
from pnt_gym.envs.vector import vector_form
from pnt_gym.errors import ActionError, ConfigError
from pnt_gym.names import unknown_name


@final
class PnTGraspEnv(CoreEnv, observes=TABLE):
    """See an object, choose where the cup grasps it, read the gauge, and throw it as fast as the grip allows.

    ## Description

    The cell of PnTConveyor-v0 with objects that a camera sees. Lids, labels, holes, dents and crumpled faces decide
    where a cup seals and how well: a force F0 at each place, from the height of the surface under the lip and from what
    leaks through the surface. The force decides whether the cup holds, how much acceleration the object survives, how
    late and with which spin the object leaves. Glossy surfaces look rough to the camera and may seal, matte paper looks
    flat and may leak.

    A pick has two phases. A step of the first phase grasps: the cup goes to a place in the picture, and the gauge reads
    the vacuum. A step of the second phase throws the object, grasps at another place, or puts the object down to ride
    on. The grasp of the first phase limits the throw of the second. A try that fails costs time only; the next step
    tries again, or lets the object ride.

    With `grasp.stages: 1` a level makes one step of both phases, a contextual bandit: grasp and throw are chosen from
    the picture alone. With `grasp.picks: belt` an episode is a shift at the moving belt, as in PnTConveyor-v0.

    With `grasp.picks: shift` an episode is a shift of unrelated objects, and observations have the last try and the
    last landing. So what stays for a shift can be learned within it: an error of the cup's place (`drift.camera`), and
    with `grasp.kinds` a few kinds that come again and again. On the level `grasp_shift` these are kinds that are drawn
    from ranges and that no agent saw; the classifier sees 0 in all of them.

    ## Action Space

    `Box(-1, 1, (6,), float32)`; with `stages: 1` `Box(-1, 1, (5,), float32)` without the third number. Zero grasps the
    outline's middle and throws as planned, at the middle pace. Numbers that a phase does not use are ignored. Values
    outside are clipped.

    | Num | Action | Phase | At -1 | At 1 |
    |---|---|---|---|---|
    | 0 | place of the cup along the belt, from the picture's middle | grasp | -0.10 m | 0.10 m |
    | 1 | place of the cup across the belt, towards the bins | grasp | -0.10 m | 0.10 m |
    | 2 | above 1/2: grasp again, at 0 and 1; below -1/2: let the object ride | after a try | | |
    | 3 | pace: largest acceleration, as a share of the robot's 120 m/s2 | throw | 0.18 | 0.60 |
    | 4 | release point along the throw line, as in PnTConveyor-v0 | throw | -0.20 m | 0.20 m |
    | 5 | release point sideways, as in PnTConveyor-v0 | throw | -0.06 m | 0.06 m |

    A place from which no throw reaches the bin is moved towards the picture's middle, and a pace at which no throw
    reaches it is raised; `info["place"]` and `info["pace"]` are what was done. `pixel_action(row, column)` of the
    unwrapped environment is the action with its cup at a pixel. A further try takes 0.20 s, in which belt and hand move
    on; an object that would leave the window meanwhile has no further try, and its last number 2 is read as a throw. On
    levels with `grasp.skip: true` an object may ride on before the first try too; the hand then goes on at once.

    ## Observation Space

    `Dict(image=Box(0, 255, (5, 48, 48), uint8), vector=Box(-5, 5, ({entries},), float32))`.

    `image` is the picture of a depth camera above the belt: height above the belt [mm], 255 where the height is known
    and 0 where it is not, red, green and blue. A pixel is 5 mm wide; columns go along the belt, rows from the bins'
    side to the near side. The picture's middle is the middle of the outline, with an error of 3 mm; the cup goes to its
    place with a further error of 4 mm, which nobody sees. The picture stays the same until the next object comes.

    In shifts of unrelated objects there is a third array, `last`, `Box(-5, 5, (16,), float32)`: whether the last step
    was a try, whether the object hung after it, vacuum and place of the try, whether the step threw, the pace, whether
    the cup lost the object, and the eight entries of PnTAdapt-v0 on the last landing. The last of these, `shift_gone`,
    is 0 until the first object is over.

    `vector` has measurements as (value - centre) / scale, clipped. The five entries of gauge and scales are 0 before
    the object hangs. With the object under the cup, the plan is that from the place of the cup. No hidden value enters.

    {observations}

    ## Rewards

    At the end of a pick the sum of the three terms of PnTConveyor-v0, `reward_landing`, `reward_success` and
    `reward_time`; 0 in a step after which the object hangs, or is grasped again. Tries count in the cycle's time.

    Every step has in `info` whether the object hangs under the cup (`held`), the number of `tries` at this object, the
    `place` of the last try from the picture's middle [m], its `vacuum` by the gauge [N] and its true `leak` (1: as the
    item's own surface). A step that ends a pick has the `info` of PnTConveyor-v0 too, and the `pace` of the throw; its
    `held` and `tries` are those of the pick that ends.

    ## Starting State

    As PnTRelease-v0: an object, a pick point and a bin that are drawn from the level, with the cup in the picture's
    middle. With `grasp.picks: belt` as PnTConveyor-v0. With `grasp.picks: shift` the kinds and the errors of the shift
    are drawn from generators of their own.

    ## Episode End

    Termination at the end of the pick; in shifts truncation after `picks_per_shift` picks.

    ## Arguments

    | Parameter | Type | Default | Description |
    |---|---|---|---|
    | `level` | str, path, mapping or GraspConfig | `"grasp"` | a shipped level, one of PnTConveyor-v0, or your own |
    | `action_mode` | str or None | None | there is one, `grasp` |
    {arguments}

    ## Version History

    * v0: first version.
    """

    core: GraspCore

    @classmethod
    def load_config(cls, level: Level) -> GraspConfig:
        """The config of a level."""
        return GraspConfig.load(level)

    @classmethod
    def make_core(cls, level: Level, action_mode: str | None, count: int, threads: int) -> GraspCore:
        """`count` cells of a level."""
        if action_mode not in (None, MODE):
            raise ConfigError(unknown_name("action_mode", action_mode, (MODE,)))
        with describes_a_cell():
            return GraspCore(cls.load_config(level), count, threads)

    def pixel_action(self, row: int, column: int) -> NDArray[np.float32]:
        """The action whose cup is at a pixel of the picture, with all other numbers 0.

        Args:
            row: row of the pixel, 0 at the bins' side.
            column: column of the pixel, 0 upstream.

        Raises:
            ActionError: the pixel is outside of the picture, or farther from its middle than the cup goes.
        """
        in_picture = 0 <= row < PIXELS and 0 <= column < PIXELS
        reach = self.core.config.grasp.reach
        place: Floats = pixel_places()[row, column] / reach if in_picture else np.full(2, np.inf)
        if np.abs(place).max() > 1.0:
            raise ActionError(
                f"pixel is ({row}, {column}); row and column must be from 0 to {PIXELS - 1}, and within {reach:g} m of "
                "the picture's middle"
            )
        action: NDArray[Any] = np.zeros(self.core.action_space.shape, dtype=np.float32)
        action[:2] = place
        return action


PnTGraspVectorEnv = vector_form(PnTGraspEnv)
