"""Names of the learning algorithms, and groups of them."""

from __future__ import annotations

from typing import Final, Literal, get_args

Residual = Literal["sac", "td3", "ppo", "tqc", "recurrent_ppo"]
Masked = Literal["maskable_ppo", "residual_ppo"]
Algorithm = Literal[Residual, Masked]
RESIDUAL: tuple[Residual, ...] = get_args(Residual)
"""Algorithms that learn a residual: they correct throws."""
MASKED: tuple[Masked, ...] = get_args(Masked)
"""Algorithms for masked discrete actions: they choose the next object on a line."""
SCORING: tuple[Algorithm, ...] = ("residual_ppo",)
"""Algorithms whose policies are scorers: one network scores each choice."""
ON_POLICY: tuple[Algorithm, ...] = ("ppo", "recurrent_ppo")
"""Algorithms that learn from every step once, and have no replay buffer."""
RECURRENT: tuple[Algorithm, ...] = ("recurrent_ppo",)
"""Algorithms with recurrent policies, which remember earlier observations of a shift."""
SEEING: tuple[Algorithm, ...] = ("sac", "ppo")
"""Algorithms that learn from pictures beside vectors."""
MAX_STACK: Final = 100
"""Observations that a policy sees at once, at most."""
MOST_MODEL: Final = 2**28
"""Largest size of a model file, compressed or not [bytes]."""
