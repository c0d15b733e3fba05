"""Films, pictures and windows of cells that work."""
