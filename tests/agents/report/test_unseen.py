"""The sentence on objects and bins that no learner saw."""

from agents.report.unseen import FAR, NEAR, unseen_sentence

GAIN = {"value": 2.46, "low": 1.31, "high": 3.84}


def row(who: str, level: str, pace: float, gain: dict | None = None) -> dict:
    return {"who": who, "level": level, "sorted_per_min": pace} | ({} if gain is None else {"gain": gain})


def test_the_sentence_names_paces_and_the_gains_of_the_networks_that_are_there() -> None:
    rows = [row(who, level, 60.0) for who in ("tuned rule", "network", "oracle") for level in (NEAR, FAR)]
    text = unseen_sentence(
        {"rows": rows[:2] + rows[4:] + [row("network", FAR, 41.0), row("network", NEAR, 64.0, GAIN)]}
    )
    assert "the rule sorts 60.0 and 60.0 a minute, networks of three seeds 64.0 and 41.0" in text
    assert text.endswith("There the gain on the rule is for networks that see colours and depths +2.5 (+1.3..+3.8).")
    both = [
        *rows,
        row("network on depths", NEAR, 66.0, GAIN),
        row("network on depths", FAR, 44.0, {**GAIN, "low": 0.0}),
    ]
    with_depths = unseen_sentence(
        {"rows": [r for r in both if r["who"] != "network" or r["level"] == FAR] + [row("network", NEAR, 64.0, GAIN)]}
    )
    assert "for those that see depths alone +2.5 (+1.3..+3.8), for networks" in with_depths
