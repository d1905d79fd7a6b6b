"""Settings of every test."""

import os
import signal
import tempfile
import tomllib
from importlib.metadata import distribution
from pathlib import Path

import pytest
from hypothesis import settings

# A slow machine is no failure: what has a bound in time says so in its own test.
settings.register_profile("fairlead", deadline=None)
settings.load_profile("fairlead")

# Skills that whoever runs the tests has installed are not part of what is tested.
os.environ["FAIRLEAD_SKILLS"] = str(Path(tempfile.gettempdir()) / "fairlead-tests-no-skills")

# A shell starts what it runs in the background with Ctrl-C ignored, and children inherit that:
# the processes that tests interrupt must hear it wherever the tests were started.
signal.signal(signal.SIGINT, signal.default_int_handler)

# What is registered in pyproject.toml is found in the metadata of the installation.
_project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text("utf-8"))
_registered = {(one.group, one.name, one.value) for one in distribution("fairlead").entry_points}
for _group, _named in _project["project"]["entry-points"].items():
    if not {(_group, name, value) for name, value in _named.items()} <= _registered:
        pytest.exit(f"{_group} in pyproject.toml has changed; install it: scripts/setup", 2)
