"""A level from measured throws: log, model, posterior, misfit, the next throws, and a page."""
