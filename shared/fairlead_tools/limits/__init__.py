"""Every limit of a robot as the gate enforces it, and the check and the tests behind each."""
