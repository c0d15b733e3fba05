"""Success of this project's controllers on the level `contact` as it is shipped: some goals, several throws at once."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from typing import Final

import numpy as np

from pnt_gym.cells.one_joint.tasks import PUSHED

from ...controllers import make_controller
from ...ground.environments import make_vector
from ...judging.evaluation import held_out, practise
from ...judging.throws import Throws
from ..finding import Findings, Row
from ..grids import listed
from .cases import percent
from .contact_learning import CONTROLLERS, NEAR

SEEDS: Final = (0, 1, 2, 3, 4, 5)
"""Of practice and held-out throws."""
PRACTICE, HELD, ROWS = 240, 96, 16
"""Throws of practice, some 30 per goal, held-out throws, and cells side by side."""


def level_findings(seeds: Sequence[int] = SEEDS, practice: int = PRACTICE, held: int = HELD) -> Findings:
    """Held-out throws of each controller, with and without practice."""
    rows: list[Row] = []
    with closing(make_vector("OneJointThrow-v0", "contact", ROWS, threads=1)) as env:
        for name in ("analytic", *CONTROLLERS):
            controller, throws = make_controller(name, env), list[Throws]()
            for seed in seeds:
                controller.reset(seed)
                practise(controller, env, practice, seed)
                throws.append(held_out(controller, env, held, seed))
            rows.append(_row(name, throws, practice))
    return listed("Level contact", rows, drop="miyashita/")


def _row(name: str, throws: list[Throws], practice: int) -> Row:
    by_seed = [percent(one.is_success) for one in throws]
    learned = "" if name == "analytic" else f", after {practice} throws of practice with {len(PUSHED)} goals"
    note = (
        f"of {sum(map(len, throws))} held-out throws on the level `contact` {NEAR}{learned}, {len(throws)} seeds, "
        f"{ROWS} cells side by side"
    )
    return Row.ours(f"miyashita/contact/level/{name}", float(np.mean(by_seed)), "%", note=note, success_by_seed=by_seed)
