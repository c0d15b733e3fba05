"""Tools of lines: plan one, find settings, teach a policy, count what becomes of throws."""
