"""Names of the learning algorithms, and which of them have what in common."""

from __future__ import annotations

from typing import Final, Literal, get_args

OfThrows = Literal["sac", "td3", "ppo", "tqc", "recurrent_ppo"]
OfChoices = Literal["maskable_ppo", "residual_ppo"]
Algorithm = Literal[OfThrows, OfChoices]
ALGORITHMS: tuple[OfThrows, ...] = get_args(OfThrows)
"""Those that correct throws."""
CHOOSING: tuple[OfChoices, ...] = get_args(OfChoices)
"""Those that choose, of what a mask says there is."""
SCORING: tuple[Algorithm, ...] = ("residual_ppo",)
"""Those whose policies are scorers, one network for all choices alike."""
ON_POLICY: tuple[Algorithm, ...] = ("ppo", "recurrent_ppo")
"""Those that learn from every step once, and keep no memory of throws."""
RECURRENT: tuple[Algorithm, ...] = ("recurrent_ppo",)
"""Those whose policies remember what they have seen of a shift."""
MOST_MODEL: Final = 2**28
"""Bytes of a model, packed or not."""
