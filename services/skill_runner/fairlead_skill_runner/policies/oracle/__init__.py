"""A scripted expert for the mobile pick-and-place task: it sees the state vector alone."""
