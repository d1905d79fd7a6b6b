"""Is what the gate releases safe, and does it release good rows? ``python -m bench.soundness``."""
