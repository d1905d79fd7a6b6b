"""Days of real gates, recorded for the gate's own tests: ``python -m bench.days``."""
