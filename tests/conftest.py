"""Settings of every test."""

import os
import tempfile
from pathlib import Path

from hypothesis import settings

# A slow machine is no failure: what has a bound in time says so in its own test.
settings.register_profile("fairlead", deadline=None)
settings.load_profile("fairlead")

# Skills that whoever runs the tests has installed are not part of what is tested.
os.environ["FAIRLEAD_SKILLS"] = str(Path(tempfile.gettempdir()) / "fairlead-tests-no-skills")
