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
from pnt_gym.errors import ConfigError, one_sentence


@final
class PnTLineEnv(CoreEnv, observes=LineTables()):
    """A shift at a line of one to four robots that throw waste off one belt: which object, into which bin, how fast.

    ## Description

    Objects lie on a belt as they fall, several abreast, in a steady stream or in bursts. Robots stand along it, each
    with a window, bins and skills of its own; what none of them takes is lost at the belt's end. Every throw is that
    of PnTConveyor-v0. What is decided here is the *order*: one step is one decision of the robot in the line that is
    free first. It takes an object, the hand meets it on the belt, throws it, and stands still; then it decides again.
    An object that a robot has chosen is reserved. A cup that fails to seal costs its time, and the object rides on,
    to be tried again, by this robot or another one.

    Early decisions pay later: an object left for a robot downstream is one more that this one can take, a far throw
    leaves the hand where the next object is not. A robot that takes what is best for itself is the baseline.

    What becomes of a throw follows the level's `throws`: `table`, chances by item, speed and distance that were
    counted in the full physics, `flight`, or `full`. The same seed gives the same stream in all three. Carried
    objects pass over others on the belt, and what is lost on the way does not come back to it.

    ## Action Space

    `Discrete(16)`: one of the choices that the observation tells of, each an object, a bin that takes it and a speed
    setting, as the planner has them. `info["action_mask"]`, a boolean array (16,), says which there are, and so does
    the method `action_masks()`. The best come first, by value x chance less the price of the cycle's time. Objects
    that can be lifted within 3 s are among them, so that choosing one of those is waiting for it. An action that the
    mask rules out is carried out as standing still for 0.1 s, with `info["invalid_action"]`.

    ## Observation Space

    `Box(-5, 5, ({entries},), float32)`: as (value - centre) / scale, clipped. Nothing hidden enters.
    `pnt_gym.cells.line.observation.decoded` turns observations back into physical values.

    {observations}

    ## Rewards

    The value that the decision brings in, if its throw ends in a bin that takes the object and before the shift is
    over, less the price of the time until the next decision in the line: `price_of_time` of the level, 1 a second.
    Since a shift has a fixed length, the price is the same for all in the end.

    `info` also has `by` (the robot that has just decided), `robot` (whose turn it is now), `dt` (time between these
    decisions [s]), `object` (its number in the stream; -1 for none), `item` and `true_kind` (what it is taken for,
    and is: indices of the cell's `items`), `bin` (of that robot), `percent` (speed setting), `value` (brought in),
    `picked` (the cup sealed), `is_success` (it crossed the opening and lies in the bin), `sorted` (and belongs
    there), `ended_in` (bin in which it lies, -1 for none), `start` (of the decision, since the begin of the shift),
    `cycle_time`, `wait_time` [s], and where throws are simulated `landing_error` [m] and `energy` [J], NaN of what
    was not picked.

    When a shift is over, `info` has its figures: `shift_value_per_min`, `shift_sorted_per_min`, `shift_attempts`,
    `shift_objects` (those that were taken or have passed the end), `shift_sorted`, `shift_misplaced` (in a bin that
    takes other things), `shift_on_floor`, `shift_passed`, `shift_recovery` and `shift_value_recovery` (share of those
    objects, and of their value, that was sorted), `shift_purity` (share of what lies in bins that belongs there),
    `shift_recovery_by_item`, `shift_passed_by_item`, `shift_passed_value_per_min` and `shift_passed_tried` (what has
    passed the end, all of which some robot takes: its value, and the share that one has tried to lift),
    `shift_picks_by_robot` and `shift_utilisation` (share of the time that each robot works, standstill above the belt
    not included).

    ## Starting State

    A belt that is filled from the camera to its end, and hands above the middle of it. All that comes in a shift is
    drawn when it begins, so the same seed gives the same stream whatever is decided.

    ## Episode End

    Truncation when the next decision of the line would fall after the end of the shift, 120 s unless the level says
    otherwise.

    ## Arguments

    | Parameter | Type | Default | Description |
    |---|---|---|---|
    | `level` | str, path, mapping or LineConfig | `"single"` | a shipped level, or one of your own |
    | `action_mode` | str or None | None | there is one, `choice` |
    {arguments}

    `reset` takes no request for an item or a target here. `core.use(policy)` of the unwrapped environment has throws
    corrected by a policy of PnTRelease-v0, where they are simulated.

    Of a single line there are pictures: `rgb_array` is the line at the moment of the decision, `rgb_array_list` what
    has happened since the decision before, so that the lists of a shift are one film at its true rate. Hands go to
    their objects as planned. With `throws: full` the throw that was simulated is shown, with `flight` the same throw
    with the robot simulated too. With `table` nothing was thrown: the hand moves as planned, the object flies without
    air from the planned release to the middle of its bin, lies there if the table has it so, and is gone if not.

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
            raise ConfigError(f"action_mode is {one_sentence(repr(action_mode), 80)}; a line has {MODE!r}")
        with describes_a_cell():
            return LineCore(cls.load_config(level), count, threads)

    def action_masks(self) -> NDArray[np.bool_]:
        """The choices that there are (16,); by the name that sb3-contrib asks for."""
        return self.core.masks()[0]


PnTLineVectorEnv = vector_form(PnTLineEnv, pictured=False)
