"""The manual of an environment, which is its docstring: sections, and what stands in every manual."""

from __future__ import annotations

import inspect
from typing import Final, Protocol

SECTIONS: Final = (
    "Description",
    "Action Space",
    "Observation Space",
    "Rewards",
    "Starting State",
    "Episode End",
    "Arguments",
    "Version History",
)
"""Sections of a manual, in Gymnasium's order."""
ARGUMENTS: Final = """\
| `threads` | int | 1 (vector: 2) | physics threads; results do not depend on it |
| `render_mode` | str or None | None | `rgb_array`: coming throw, `rgb_array_list`: last throw, `human` |
| `width` | int | 1280 | width of a frame [pixels], up to 1920 |
| `height` | int | 720 | height of a frame [pixels], up to 1080 |
| `camera` | mapping or None | None | `lookat` (x, y, z) [m], `distance` [m], `azimuth`, `elevation` [deg] to change |
| `num_envs` | int | 1 | number of cells; vector form alone (`gymnasium.make_vec`) |
| `autoreset_mode` | str or AutoresetMode | `"SameStep"` | vector form: `SameStep`, `NextStep` or `Disabled` |
| `max_episode_steps` | int or None | None | vector form: steps of an episode; `gymnasium.make` adds a TimeLimit |
| `disable_env_checker` | bool or None | None | vector form, which has no checker: True or None |

`reset(options={"item": ..., "target": ...})` chooses item, target or both for the first throw of an episode, by name or
index. The throw is drawn until it meets the request; later throws are drawn as always. In the vector form the request
holds for every cell that is reset; the option `reset_mask`, a boolean array, chooses these cells."""
"""Rows that the table of arguments has in every manual, and the options of a reset."""


class Entries(Protocol):
    """Entries of an observation, as a manual lists them."""

    def __len__(self) -> int:
        """Numbers in an observation."""
        ...

    def markdown(self) -> str:
        """One row per entry."""
        ...


def completed(own: str, family: str) -> str:
    """A manual with the sections of its family; of a section that both have, the family's part comes first."""
    own, family = inspect.cleandoc(own), inspect.cleandoc(family)
    parts: dict[str, list[str]] = {title: [] for title in SECTIONS}
    for text in (family, own):
        for section in text.split("\n## ")[1:]:
            title, body = section.split("\n", 1)
            parts[title].append(body.strip())
    written = [f"## {title}\n\n" + "\n\n".join(bodies) for title, bodies in parts.items() if bodies]
    return "\n\n".join([own.split("\n\n", 1)[0], *written])
