"""Former name of `agents.line tune`."""

import sys

print(f"error: {__package__}.tune is `python -m {__package__}.line tune` now", file=sys.stderr)
sys.exit(2)
