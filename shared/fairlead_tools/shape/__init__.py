"""A robot's shape: the geometry of its links, capsules around it, and which of them can meet."""
