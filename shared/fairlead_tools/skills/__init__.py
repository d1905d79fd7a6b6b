"""Starting a new skill, installing one, and what its checkpoint says about it."""
