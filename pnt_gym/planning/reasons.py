"""Reason codes of batched plans, each with the sentence that a user reads."""

from __future__ import annotations

from enum import IntEnum
from typing import Self, final


class ReasonCode(IntEnum):
    """Abstract base of reason codes: a member is its integer code and holds its sentence."""

    sentence: str

    def __new__(cls, code: int, sentence: str = "") -> Self:
        """Create a member from its code and sentence, or return the member of a code."""
        member = int.__new__(cls, code)
        member._value_ = code
        member.sentence = sentence
        return member


@final
class InterceptReason(ReasonCode):
    """Why an object cannot be picked."""

    FEASIBLE = 0, "the object can be picked"
    PASSED = 1, "the object has left the window before it may be picked"
    NEVER_ENTERS = 2, "the object does not come into the window in time"
    TOO_LATE = 3, "the hand cannot reach the object before it leaves the window"
