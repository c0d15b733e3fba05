"""Config of a cell that grasps: the conveyor's cell, surfaces of its objects, and the rules of grasp and throw."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal, cast, final

from pydantic import Field, model_validator

from pnt_gym.cells.base.config import Duration, LevelConfig, NonNegative, Positive, Section, Share
from pnt_gym.cells.base.items import Item
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.grasp.drawn import drawn_kinds

MOST_TRIES = 5
"""Largest number of tries to grasp an object."""
CHANNELS, PIXELS = 5, 48
"""Channels of a picture, and pixels along each of its sides."""
PIXEL = 0.005
"""Side of a pixel on the belt [m]."""
MOST_DRAWN = 1000
"""Largest number of drawn kinds."""


class Surface(Section):
    """Seal of a cup by its place on an object, see `cells.grasp.surfaces`."""

    spread: NonNegative = Field(
        default=0.15, le=2, description="Standard deviation of ln F0 from try to try at one place, assumed."
    )
    pressure: Positive = Field(
        default=3000.0,
        le=100_000,
        description="Least vacuum at which the gauge calls a grasp held, over the area of the cup; assumed [Pa].",
    )
    weights: Positive = Field(
        default=2.0, le=100, description="Least force of a held object, as a multiple of its weight; assumed."
    )


class PictureCamera(Section):
    """The camera that looks down on the objects before the robot."""

    outline: NonNegative = Field(
        default=0.003,
        le=0.1,
        description="Standard deviation of the place of the outline's middle in the picture, along x and y; the "
        "picture's middle is the place of a grasp of zero; assumed [m].",
    )


class Grasping(Section):
    """Rules of grasp and throw."""

    stages: Literal[1, 2] = Field(
        default=2,
        description="2: a step grasps, the gauge tells how well, and the next step throws. 1: one step does both.",
    )
    tries: Annotated[int, Field(ge=1, le=MOST_TRIES)] = Field(
        default=2, description="Tries to grasp an object, with `stages: 2`."
    )
    retry: Duration = Field(
        default=0.20,
        description="Time of each further try, in which the belt moves on; assumed [s].",
    )
    skip: bool = Field(
        default=False,
        description="Whether an object may ride on before the first try. The hand then goes on at once, without the "
        "dwell of a try; not on the belt.",
    )
    reach: Annotated[float, Field(gt=0, le=0.115)] = Field(
        default=0.100, description="Distance of the cup from the picture's middle along x or y, for an action of 1 [m]."
    )
    pace: tuple[Share, Share] = Field(
        default=(0.18, 0.60),
        description="Largest acceleration of a throw for an action of -1 and of 1, as shares of the robot's 120 m/s2; "
        "the speed setting stays an upper bound.",
    )
    picks: Literal["independent", "shift", "belt"] = Field(
        default="independent",
        description="Unrelated objects, one in each episode (independent); a shift of `picks_per_shift` unrelated "
        "objects, whose observations have the last try and the last landing, so that a shift's `drift` and kinds can "
        "be learned (shift); or a shift of as many objects on the belt (belt).",
    )
    kinds: Annotated[int, Field(ge=1, le=MOST_DRAWN)] | None = Field(
        default=None,
        description="Number of different kinds in each shift, drawn from the level's when the shift begins; the k-th "
        "comes as often as one over k. null: all. For `picks: shift`.",
    )
    objects: Annotated[int, Field(ge=1, le=3)] = Field(
        default=1,
        description="Objects within reach, of which the cup's place chooses one; more than one with independent picks.",
    )


class Drawn(Section):
    """Kinds of objects that are drawn from ranges, see `cells.grasp.drawn`."""

    kinds: Annotated[int, Field(ge=0, le=MOST_DRAWN)] = Field(
        default=0, description="Number of kinds that are drawn, which come instead of `items`; 0: the items come."
    )
    seed: Annotated[int, Field(ge=0, lt=2**32)] = Field(default=0, description="Seed from which they are drawn.")
    areal: Annotated[float, Field(ge=0, le=3)] = Field(
        default=0.75,
        description="Least mass over the area from above; lighter kinds, which air carries away from any bin, are "
        "drawn again. The lightest of the catalogue have 0.78 [kg/m2].",
    )


@final
class GraspConfig(ConveyorConfig):
    """A cell that grasps and throws. The defaults are the conveyor's level `nominal` without its bins."""

    folder = "grasp"
    parent: ClassVar[type[LevelConfig] | None] = ConveyorConfig

    surface: Surface | None = Field(
        default=None,
        description="Whether cups seal by their place on an object, as the item's `zones` say. null: every place "
        "within the outline seals with the item's `pick_chance`, as in the conveyor's cell.",
    )
    camera: PictureCamera = PictureCamera()
    grasp: Grasping = Grasping()
    drawn: Drawn = Drawn()

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: object) -> object:
        """The level with the names of drawn kinds as its items; a section that is wrong is refused by its own form."""
        values = _keys_of(data)
        drawn = values.get("drawn")
        count: Any = drawn.kinds if isinstance(drawn, Drawn) else _keys_of(drawn).get("kinds")
        if not isinstance(count, int) or not 0 < count <= MOST_DRAWN:
            return data
        return {**values, "items": [f"drawn_{k}" for k in range(count)], "extra_items": ()}

    def item_definitions(self) -> Mapping[str, Item]:
        """The items of the catalogue, of `extra_items`, and those that are drawn, by name."""
        drawn = drawn_kinds(self.drawn.kinds, self.drawn.seed, self.drawn.areal)
        return {**super().item_definitions(), **{item.name: item for item in drawn}}

    @property
    def remembers(self) -> bool:
        """Whether episodes are shifts whose observations have the last try and the last landing."""
        return self.grasp.picks == "shift"

    def problems(self) -> Iterator[str]:
        """A sentence for each problem of values that are possible alone, and not together."""
        yield from super().problems()
        rules, (slow, fast), kinds = self.grasp, self.grasp.pace, self.grasp.kinds
        clauses = (
            (slow > fast, f"grasp.pace runs from {slow:g} to {fast:g}; the first value must not be larger"),
            (
                rules.skip and rules.picks == "belt",
                "grasp.skip is true; on the belt, where a hand has reached the object that it sees, it must be false",
            ),
            (
                rules.objects > 1 and rules.picks != "independent",
                f"grasp.objects is {rules.objects}; it must be 1 in a shift",
            ),
            (
                kinds is not None and not self.remembers,
                f"grasp.kinds is {kinds}; without grasp.picks: shift it must be null",
            ),
            (
                kinds is not None and kinds > len(self.items),
                f"grasp.kinds is {kinds}; the level has {len(self.items)} items, so it must be at most as many",
            ),
            (
                kinds is not None and self.mix,
                "mix: with grasp.kinds, a shift's kinds have frequencies of their own; leave mix out",
            ),
            (
                rules.tries > 1 and not self.belt.tracking,
                f"grasp.tries is {rules.tries}; without belt.tracking it must be 1",
            ),
            (
                self.cells.ranges and not self.remembers,
                "cells: only grasp.picks: shift shows landings from which a cell could be learned; leave cells out",
            ),
            (
                self.drift.moves and not self.remembers,
                "drift: only grasp.picks: shift shows landings from which a drift could be learned; set its parts to 0",
            ),
        )
        yield from (sentence for is_wrong, sentence in clauses if is_wrong)


def _keys_of(section: object) -> dict[str, Any]:
    """The keys of a section that is not checked yet; none of what is no section."""
    return {**cast("Mapping[str, Any]", section)} if isinstance(section, Mapping) else {}
