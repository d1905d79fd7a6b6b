"""Settings of every test."""

from hypothesis import settings

# A slow machine is no failure: what has a bound in time says so in its own test.
settings.register_profile("fairlead", deadline=None)
settings.load_profile("fairlead")
