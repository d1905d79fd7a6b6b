"""A robot.yaml to change."""

import json
from typing import Any

import pytest
import yaml

from fairlead.paths import robot_dir


@pytest.fixture(scope="module")
def shipped() -> dict[str, Any]:
    loaded: dict[str, Any] = yaml.safe_load((robot_dir("panda_mobile") / "robot.yaml").read_text())
    return loaded


@pytest.fixture
def data(shipped: dict[str, Any]) -> dict[str, Any]:
    copied: dict[str, Any] = json.loads(json.dumps(shipped))  # YAML's aliases taken apart
    del copied["safety"]["hardware"], copied["to_confirm"]  # each complaint once
    return copied
