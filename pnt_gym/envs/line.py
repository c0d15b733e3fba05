"""Robots along one belt: who takes what next."""

from __future__ import annotations

from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.base.canvas import FPS
from pnt_gym.cells.base.config import Level, describes_a_cell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import MODE, LineCore
from pnt_gym.cells.line.observation import LineTables
from pnt_gym.envs.base import CoreEnv
from pnt_gym.envs.vector import vector_form
from pnt_gym.errors import ConfigError
from pnt_gym.names import unknown_name


@final
class PnTLineEnv(CoreEnv, observes=LineTables()):
    """A shift at a line of one to four robots that throw waste off one belt: which object, into which bin, how fast.

    ## Description

    Objects lie on a belt as they fall, several abreast, in a steady stream or in bursts. Robots stand along the belt,
    each with a window, bins and skills of its own. An object that no robot takes is lost at the end of the belt. Every
    throw is that of PnTConveyor-v0. An agent decides the *order*: one step is one decision of the robot that is free
    first. The robot takes an object, its hand meets the object on the belt, throws it, and stands still; then the robot
    decides again. A chosen object is reserved. A cup that fails to seal costs its time. The object then rides on, and
    this robot or another one may try it again.

    Early decisions pay later. An object left to a robot downstream frees time for this robot. A far throw leaves the
    hand far from the next object. A robot that takes what is best for itself is the baseline.

    The level's key `throws` says how the result of a throw is found: `table` (chances by item, speed and distance,
    counted in the full physics), `flight` or `full`. The same seed gives the same stream in all three. Carried objects
    pass over other objects on the belt, and a dropped object does not come back to the belt.

    ## Action Space

    `Discrete(16)`: a choice of the observation. A choice is an object, a bin that takes the object, and a speed
    setting, as planned. `info["action_mask"]`, a boolean array (16,), marks the choices that exist, and so does the
    method `action_masks()`. The best choices come first, by value x chance less the price of the cycle's time. Objects
    that can be lifted within 3 s are among the choices; to choose a later object is to wait for it. An action outside
    the mask is carried out as standing still for 0.1 s, with `info["invalid_action"]`.

    ## Observation Space

    `Box(-5, 5, ({entries},), float32)`: as (value - centre) / scale, clipped. No hidden value enters.
    `pnt_gym.cells.line.observation.decoded` turns observations back into physical values.

    {observations}

    ## Rewards

    The value of the object, if the throw ends in a bin that takes the object before the shift is over, less the price
    of the time until the next decision of the line: `price_of_time` of the level, 1 a second. A shift has a fixed
    length, so the sum of all prices is the same for every controller.

    `info` also has these keys:

    | Key | Unit | Meaning |
    |---|---|---|
    | `by`, `robot` | - | robot that has just decided; robot that decides next |
    | `dt` | s | time between these two decisions |
    | `start` | s | moment of the decision, since the begin of the shift |
    | `object` | - | number of the chosen object in the stream; -1 for none |
    | `item`, `true_kind` | - | seen and true class of the object: indices of the cell's `items` |
    | `bin` | - | bin of the choice: index of the robot's bins |
    | `percent` | % | speed setting |
    | `value` | - | what the decision earned |
    | `picked` | bool | the cup sealed |
    | `is_success` | bool | the object crossed the opening and lies in the bin |
    | `sorted` | bool | a success in a bin that takes the true class |
    | `ended_in` | - | bin in which the object lies at the end, -1 for none |
    | `cycle_time`, `wait_time` | s | time of the robot; the part in which its hand waits above the belt |
    | `landing_error`, `energy` | m, J | only where throws are simulated; NaN for a failed pick |

    When a shift is over, `info` has `episode_success`, the share of the decisions that succeeded, and the figures of
    the shift:

    | Key | Meaning |
    |---|---|
    | `shift_value_per_min`, `shift_sorted_per_min` | value and sorted objects per minute |
    | `shift_attempts` | picks that robots tried |
    | `shift_objects` | objects that were taken or have passed the end of the belt |
    | `shift_sorted`, `shift_sorted_by_item` | objects in a bin that takes them |
    | `shift_misplaced`, `shift_misplaced_by_item` | objects in a bin that takes other items |
    | `shift_on_floor`, `shift_on_floor_by_item` | thrown objects in no bin |
    | `shift_passed`, `shift_passed_by_item` | objects that passed the end of the belt |
    | `shift_out_of_reach`, `shift_out_of_reach_by_item` | passed objects that no robot can throw into a bin for them |
    | `shift_passed_value_per_min` | value of the objects that passed the end, per minute |
    | `shift_passed_tried` | share of the passed objects that a robot had tried to lift |
    | `shift_passed_tried_by_item` | numbers of these objects |
    | `shift_recovery`, `shift_recovery_by_item` | sorted objects over `shift_objects` |
    | `shift_value_recovery` | value of the sorted objects over that of `shift_objects` |
    | `shift_purity` | share of the objects in bins that belong there |
    | `shift_picks_by_robot` | objects that each robot lifted |
    | `shift_utilisation` | share of the time in which each robot works; waiting above the belt does not count |

    ## Starting State

    The belt is filled from the camera to its end, and the hands stand above the middle of the belt. All objects of a
    shift are drawn at its beginning, so the same seed gives the same stream under all decisions.

    ## Episode End

    Truncation when the next decision of the line would fall after the end of the shift, 120 s unless the level says
    otherwise.

    ## Arguments

    | Parameter | Type | Default | Description |
    |---|---|---|---|
    | `level` | str, path, mapping or LineConfig | `"single"` | a shipped level, or one of your own |
    | `action_mode` | str or None | None | there is one, `choice` |
    {arguments}

    A line takes no such request: `reset` refuses options for an item or a target. With `core.use(policy)` of the
    unwrapped environment a policy of PnTRelease-v0 corrects the throws of the line, where throws are simulated.

    Only the single form has pictures: `rgb_array` is the line at the moment of the decision, `rgb_array_list` the time
    since the last decision, so the lists of a shift are one film at its true rate. Hands go to their objects as
    planned. With `throws: full` the picture shows the simulated throw, with `flight` the same throw with the robot
    simulated too. With `table` no throw is simulated: the hand moves as planned, and the object flies without air from
    the planned release to the middle of its bin. The object lies there if the table counts a success, and disappears if
    not.

    ## Version History

    * v0: first version.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array", "rgb_array_list"], "render_fps": FPS}  # pyright: ignore[reportIncompatibleVariableOverride]

    core: LineCore

    @classmethod
    def load_config(cls, level: Level) -> LineConfig:
        """The config of a level."""
        return LineConfig.load(level)

    @classmethod
    def make_core(cls, level: Level, action_mode: str | None, count: int, threads: int) -> LineCore:
        """`count` lines of a level."""
        if action_mode not in (None, MODE):
            raise ConfigError(unknown_name("action_mode", action_mode, (MODE,)))
        with describes_a_cell():
            return LineCore(cls.load_config(level), count, threads)

    def action_masks(self) -> NDArray[np.bool_]:
        """The choices that there are (16,); by the name that sb3-contrib asks for."""
        return self.core.masks()[0]


PnTLineVectorEnv = vector_form(PnTLineEnv, pictured=False)
