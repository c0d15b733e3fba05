"""How controllers are judged: throws, work shifts, and what they come to."""
