"""Documents made of the tests, sentences that they hold: ``python -m bench.pages``."""
