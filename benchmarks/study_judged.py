"""What picks that fail, classes that are told wrong and bins that fill cost at the belt, as a sorter is judged.

Two cells throw the fifteen kinds of `waste`: `waste_plain`, with a bin drawn for every throw, and `boxes`, six fixed
bins by material, in which what misses its own may end in another. Each effect alone, all together, and all that the
honest levels have besides; the planner's throws and those of the policy that ships.

Run: python benchmarks/study_judged.py --throws 800 --json results/judged.json      (minutes)
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any, Final

from agents.ground.files import write_json
from agents.ground.places import POLICY
from agents.judging.evaluation import evaluate
from benchmarks.study import study_options, study_parser
from pnt_gym.cells.conveyor.config import ConveyorConfig

MATERIALS: Final[dict[str, tuple[str, ...]]] = {
    "fibre": ("paper_ball", "carton"),
    "cartons": ("tetra_1l", "tetra_200"),
    "metal": ("can", "can_crushed", "foil_ball", "jar_lid", "steel_tin"),
    "bottles": ("pet_05", "pet_crushed"),
    "plastics": ("yoghurt_cup", "cap", "tray"),
    "rest": ("cork",),
}
_SPOTS: Final = ((-0.28, 0.30), (0.0, 0.30), (0.28, 0.30), (-0.28, 0.54), (0.0, 0.54), (0.28, 0.54))
BOXES: Final[dict[str, Any]] = {
    "base": "waste_plain",
    "bins": {
        "fixed": [
            {"name": name, "x": x, "y": y, "size": [0.26, 0.22], "accepts": list(items)}
            for (name, items), (x, y) in zip(MATERIALS.items(), _SPOTS, strict=True)
        ]
    },
}
LEVELS: Final[dict[str, dict[str, Any]]] = {"waste": {"base": "waste_plain"}, "boxes": BOXES}
WRONG: Final = 0.05
"""Share of every kind that is seen as another, evenly over those of other materials; assumed."""
EMPTIED: Final = {"waste": 8, "boxes": 40}
"""Objects until a bin is emptied: about when one of `waste` (5 l) or of `boxes` (17 l) is full."""


def confusion(wrong: float) -> dict[str, dict[str, float]]:
    """Each kind is seen as one of another material in a share of cases."""
    found: dict[str, dict[str, float]] = {}
    for items in MATERIALS.values():
        others = [other for own in MATERIALS.values() if own is not items for other in own]
        found |= {item: {item: 1.0 - wrong, **dict.fromkeys(others, wrong / len(others))} for item in items}
    return found


def cases(level: str) -> dict[str, dict[str, Any]]:
    """What a level is given beside, by the name of a row."""
    fails, errs = {"pick": {"fails": True}}, {"classifier": {"confusion": confusion(WRONG)}}
    bins = {"bins": {**LEVELS[level].get("bins", {}), "emptied": EMPTIED[level]}}
    return {
        "nothing fails": {},
        "picks fail": fails,
        "classes wrong": errs,
        "bins fill": bins,
        "all three": fails | errs | bins,
        "the honest cell": {**errs, **bins, "base": "waste"},
    }


def measured(level: Mapping[str, Any], controller: str, throws: int, seed: int, threads: int) -> dict[str, Any]:
    """Figures of `throws` throws at the belt."""
    found = evaluate(controller, "PnTConveyor-v0", throws, seed, level=ConveyorConfig.load(level), threads=threads)
    names = ("picks_per_min", "sorted_per_min", "success_rate", "recovery", "purity", "pick_rate", "energy_per_pick_j")
    return {name: found[name] for name in (*names, "purity_by_bin") if name in found}


def main() -> None:
    options = study_options(study_parser(__doc__, 800, "row"))
    result: dict[str, Any] = {"throws": options.throws, "seed": options.seed, "wrong": WRONG, "emptied": EMPTIED}
    result["judged"] = {}
    for name, level in LEVELS.items():
        for controller, said in (("analytic", "analytic planner"), (str(POLICY), "shipped policy")):
            for case, more in cases(name).items():
                found = measured({**level, **more}, controller, options.throws, options.seed, options.threads)
                result["judged"].setdefault(name, []).append({"controller": said, "case": case, **found})
                shares = "  ".join(
                    f"{k} {100 * found[k]:.1f} %" for k in ("recovery", "purity", "pick_rate") if k in found
                )
                print(f"{name:<7}{said:<18}{case:<15}{found['sorted_per_min']:5.1f} sorted/min  {shares}")
                sys.stdout.flush()
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
