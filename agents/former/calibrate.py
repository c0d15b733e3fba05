"""Former name of `agents.line calibrate`."""

import sys

print(f"error: {__package__}.calibrate is `python -m {__package__}.line calibrate` now", file=sys.stderr)
sys.exit(2)
