"""Sessions of real gates, recorded for the gate's own tests."""
