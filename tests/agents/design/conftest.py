"""Pages for tests."""

from agents.design.page import Page
from pnt_gym.cells.line.config import LineConfig


def served(front, token, level="skills3"):
    """A page at a socket."""
    return Page(LineConfig.load(level), front, token)
