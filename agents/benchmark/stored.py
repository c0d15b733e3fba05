"""Policies that took long to learn, stored in a file of results: whoever verifies a row need not learn again."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, NamedTuple

from ..controllers.protocol import Learner
from ..controllers.state import save_state

POLICIES: Final = "policies"
"""Key of a file of results with the stored policies, as text, by the digests that rows name."""
STORED_FROM: Final = 20.0
"""Time of learning from which the policy of a controller that is not trained is stored [s]."""
LARGEST: Final = 400_000
"""Largest policy that is stored [bytes]: thirty larger ones would make a file of results as large as a repository."""


class Stored(NamedTuple):
    """The stored policy of a row.

    Attributes:
        throws: number of throws that the policy learned from.
        content: content of the policy's file, which holds numbers alone.
    """

    throws: int
    content: bytes


def state_bytes(controller: Learner) -> bytes:
    """Content of a file of what a controller has learned."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "state.npz"
        save_state(controller, file)
        return file.read_bytes()


def store(policies: dict[str, str], digest: str, content: bytes) -> None:
    """Add a policy, as text, to the policies of a file of results, unless the policy is too large.

    Several controllers may take over what one has learned: the second and later ones name the digest of the first.

    Args:
        policies: the stored policies by their digests; changed in place.
        digest: digest of the policy.
        content: content of the policy's file.
    """
    text = base64.b64encode(content).decode()
    if digest not in policies and len(content) <= LARGEST:
        policies[digest] = next((first for first, stored in policies.items() if stored == text), text)


def stored_policies(parts: Iterable[Mapping[str, Any]]) -> dict[str, str]:
    """All policies that pieces of work store, by their digests."""
    return {digest: text for part in parts for digest, text in part[POLICIES].items()}


def stored_policy(policies: Mapping[str, str], row: Mapping[str, Any]) -> Stored | None:
    """The policy of a row of results; None if the policy is not stored.

    Args:
        policies: the policies of the row's file, by their digests.
        row: a row of results.

    Raises:
        ValueError: the text is none of a policy.
    """
    text = policies.get(row.get("digests", {}).get("policy", ""))
    text = None if text is None else policies.get(text, text)
    return None if text is None else Stored(row["throws"], base64.b64decode(text, validate=True))
