"""The papers' figures and tables, computed anew and set beside what was published."""
