"""Miyashita et al. 2010, "Parts Assembly and Sorting by Throwing Manipulation: Planning and Control", computed anew."""

from __future__ import annotations

from agents.reproduce import (
    miyashita_accessible,
    miyashita_contact,
    miyashita_contact_learning,
    miyashita_example,
    miyashita_formulas,
    miyashita_learning,
    miyashita_tasks,
)
from agents.reproduce.findings import Part

PARTS: tuple[Part, ...] = (
    *miyashita_example.PARTS,
    *miyashita_accessible.PARTS,
    *miyashita_learning.PARTS,
    *miyashita_contact.PARTS,
    *miyashita_contact_learning.PARTS,
    *miyashita_tasks.PARTS,
    *miyashita_formulas.PARTS,
)
