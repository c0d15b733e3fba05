"""Films, pictures and live windows of cells at work."""
