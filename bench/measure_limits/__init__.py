"""What a simulated robot does with full-scale commands: ``python -m bench.measure_limits``."""
