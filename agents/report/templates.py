"""Texts from templates and expressions of Jinja, with filters that write figures with their units and intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, Final

NONE: Final = "-"
"""Text of a figure that is missing."""


class NoFigure(LookupError):
    """The results lack a controller, a level, a case or a figure that a text needs: they are of another plan."""


@cache
def environment() -> Any:
    """Jinja's environment of the report; a name that nobody has given is an error."""
    from jinja2 import Environment, StrictUndefined  # noqa: PLC0415 - needed for reports only

    made = Environment(autoescape=False, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    made.filters |= {write.__name__: write for write in (number, mm, percent, deg, count, code)}
    return made


def fill_template(template: str, values: Mapping[str, Any]) -> str:
    """A template with values in it.

    Raises:
        NoFigure: the template names something that is not among the values.
    """
    from jinja2 import UndefinedError  # noqa: PLC0415 - needed for reports only

    try:
        return environment().from_string(template).render(values)
    except UndefinedError as error:
        raise NoFigure(str(error)) from None


def cell_text(expression: str, values: Mapping[str, Any]) -> str:
    """What an expression comes to, as text; a dash where a figure is missing."""
    from jinja2 import UndefinedError  # noqa: PLC0415 - needed for reports only

    try:
        value = _compiled(expression)(values)
        return NONE if value is None else str(value)
    except (UndefinedError, TypeError):
        return NONE


@cache
def _compiled(expression: str) -> Any:
    return environment().compile_expression(expression, undefined_to_none=False)


def number(value: Any, digits: int = 1, *, sign: bool = False, unit: str = "", factor: float = 1.0) -> str:
    """A number with digits after its point, its sign, its unit, and the ends of its interval in brackets."""
    ends = [value[end] for end in ("value", "low", "high")] if isinstance(value, Mapping) else [value]
    middle, *interval = (format(factor * end, f"{'+' if sign else ''}.{digits}f") for end in ends)
    return f"{middle}{unit}" + (f" ({'..'.join(interval)})" if interval else "")


def mm(value: Any, digits: int = 1, *, sign: bool = False) -> str:
    """A length [m] in millimetres."""
    return number(value, digits, sign=sign, unit=" mm", factor=1000.0)


def percent(value: Any, digits: int = 1, *, sign: bool = False) -> str:
    """A share in percent."""
    return number(value, digits, sign=sign, unit=" %", factor=100.0)


def deg(value: Any, digits: int = 1) -> str:
    """An angle [rad] in degrees."""
    return number(value, digits, unit=" deg", factor=180.0 / math.pi)


def count(value: Any) -> str:
    """A whole number, with commas between its thousands."""
    return f"{value:,.0f}"


def code(value: Any) -> str:
    """A name as code."""
    return f"`{value}`"
