"""casadi with IPOPT, an optional dependency, loaded at first use; only this module imports casadi."""

from __future__ import annotations

import importlib
from functools import cache
from typing import Any

from pnt_gym.errors import PntGymError

QUIET = {
    "expand": True,
    "detect_simple_bounds": True,
    "print_time": False,
    "error_on_fail": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-9,
    "ipopt.constr_viol_tol": 1e-10,
    "ipopt.acceptable_tol": 1e-7,
    "ipopt.acceptable_constr_viol_tol": 1e-9,
    "ipopt.mu_strategy": "adaptive",
}
"""Options of `nlpsol` and IPOPT: silent, and tight enough for limits kept to 1e-6."""


@cache
def load_casadi() -> Any:
    """The casadi module.

    Raises:
        PntGymError: casadi is not installed.
    """
    try:
        return importlib.import_module("casadi")
    except ImportError:
        raise PntGymError(
            "motions planned as one optimum need casadi; install it with: pip install 'pnt_gym[optimal]'"
        ) from None
