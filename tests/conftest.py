"""Settings of every test."""

import os
import signal
import tempfile
from pathlib import Path

from hypothesis import settings

# A slow machine is no failure: what has a bound in time says so in its own test.
settings.register_profile("fairlead", deadline=None)
settings.load_profile("fairlead")

# Skills that whoever runs the tests has installed are not part of what is tested.
os.environ["FAIRLEAD_SKILLS"] = str(Path(tempfile.gettempdir()) / "fairlead-tests-no-skills")

# A shell starts what it runs in the background with Ctrl-C ignored, and children inherit that:
# the processes that tests interrupt must hear it wherever the tests were started.
signal.signal(signal.SIGINT, signal.default_int_handler)
