"""Former name of `agents.line plan`."""

import sys

print(f"error: {__package__}.plan_line is `python -m {__package__}.line plan` now", file=sys.stderr)
sys.exit(2)
