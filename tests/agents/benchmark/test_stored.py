"""Policies in a file of results: each content once, and none that is large."""

from __future__ import annotations

from agents.benchmark import stored


def test_a_policy_that_is_the_same_as_another_names_it() -> None:
    policies: dict[str, str] = {}
    for digest, content in {"first": b"one", "second": b"one", "third": b"three", "first ": b"three"}.items():
        stored.store(policies, digest, content)
    stored.store(policies, "first", b"three")  # the policy of a further level, which is stored already
    contents = {}
    for digest in policies:
        policy = stored.stored_policy(policies, {"throws": 5, "digests": {"policy": digest}})
        assert policy is not None
        assert policy.throws == 5
        contents[digest] = policy.content
    assert contents == {"first": b"one", "second": b"one", "third": b"three", "first ": b"three"}
    assert policies["second"] == "first"
    assert policies["first "] == "third"


def test_a_large_policy_is_learned_again() -> None:
    policies: dict[str, str] = {}
    stored.store(policies, "small", bytes(stored.LARGEST))
    stored.store(policies, "large", bytes(stored.LARGEST + 1))
    assert list(policies) == ["small"]
    assert stored.stored_policy(policies, {"throws": 5, "digests": {"policy": "large"}}) is None
