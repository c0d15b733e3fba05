"""Former name of `agents.line imitate`."""

import sys

print(f"error: {__package__}.imitate is `python -m {__package__}.line imitate` now", file=sys.stderr)
sys.exit(2)
