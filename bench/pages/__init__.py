"""Documents made of the tests: sentences that they hold, hazards: ``python -m bench.pages``."""
