"""Motion within limits of speed, acceleration and jerk: minimum-time strokes, meetings, transfers, and free flight."""
