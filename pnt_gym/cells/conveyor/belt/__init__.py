"""What lies on the belt: the stream of objects, which one is picked next, and which others a carried one meets."""
