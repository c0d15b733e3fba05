"""Every number that describes a conveyor cell, once, with its unit and its reason.

Belt, items, bins and sensors are those of any sorting line (`cells.base.sorting`); here stands what its robot adds.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self, final

from pydantic import Field, model_validator

from pnt_gym.cells.base.sorting import SortingLine
from pnt_gym.cells.conveyor.sections import ActionScale, Limits, Motion, Reward, Suction


@final
class ConveyorConfig(SortingLine):
    """A conveyor cell. The defaults are the level `nominal` without its bins."""

    timestep: Annotated[float, Field(ge=0.0001, le=0.002)] = Field(
        default=0.001,
        description="Physics step [s]; 1 ms for training, 0.4 ms for evaluation, above 2 ms the loops drift.",
    )
    limits: Limits = Limits()
    motion: Motion = Motion()
    suction: Suction = Suction()
    action: ActionScale = ActionScale()
    reward: Reward = Reward()
    planner: Literal["straight", "free_direction"] = Field(
        default="straight",
        description="How the throw is planned: on a straight line (Hassan 2022), or with a free release direction.",
    )
    picks_per_shift: Annotated[int, Field(ge=1)] = Field(default=50, description="Episode length of PnTConveyor-v0.")

    @model_validator(mode="after")
    def _check(self) -> Self:
        for item in self.item_list():
            if item.seal_force is None:
                raise ValueError(f"items: {item.name!r} has no seal_force; a suction cup cannot hold it")
        return self
