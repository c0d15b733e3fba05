"""Names of the learning algorithms, and which of them have what in common."""

from __future__ import annotations

from typing import Final, Literal, get_args

Residual = Literal["sac", "td3", "ppo", "tqc", "recurrent_ppo"]
Masked = Literal["maskable_ppo", "residual_ppo"]
Algorithm = Literal[Residual, Masked]
RESIDUAL: tuple[Residual, ...] = get_args(Residual)
"""Algorithms that learn a residual: they correct throws."""
MASKED: tuple[Masked, ...] = get_args(Masked)
"""Algorithms for masked discrete actions: they choose what comes next."""
SCORING: tuple[Algorithm, ...] = ("residual_ppo",)
"""Algorithms whose policies are scorers, one network for all choices alike."""
ON_POLICY: tuple[Algorithm, ...] = ("ppo", "recurrent_ppo")
"""Algorithms that learn from every step once, and keep no memory of throws."""
RECURRENT: tuple[Algorithm, ...] = ("recurrent_ppo",)
"""Algorithms whose policies remember what they have seen of a shift."""
MOST_MODEL: Final = 2**28
"""Bytes of a model, packed or not."""
