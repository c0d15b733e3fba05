"""The page on which a sorting line is designed: a session without a browser, and a thin page around it."""
