"""The objects: true and measured values, random draws, outlines, and how objects fill bins."""
