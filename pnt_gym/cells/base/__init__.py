"""What the cells of all robots share, once: config, core, actions, items, air, physics in stages, and pictures."""
