"""What is said of a robot.yaml that is refused."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.robot.manifest import RobotManifest
from fairlead.yaml_file import load_yaml


def refusal(data: dict[str, Any], folder: Path) -> str:
    path = folder / "robot.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False))
    with pytest.raises(ConfigError) as error:
        load_yaml(path, RobotManifest)
    return re.sub(rf"{path}(:\d+:\d+)?: ", "", str(error.value))


def top(text: str) -> str:
    return f"1 problem(s):\n  {text}"
