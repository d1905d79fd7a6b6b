"""An arm whose ticks are short and whose declared model fits a robot that does what it is told."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import yaml

from fairlead.paths import robot_dir

NAME = "quick_arm"
PERIOD_MS = 20.0
SOURCE = "tests"


def write_quick_robot(folder: Path) -> Path:
    """The UR5e as a robot of its own in ``folder``, which is returned: `FAIRLEAD_ROBOTS`."""
    shipped = robot_dir("ur5e")
    own = folder / NAME
    own.mkdir(parents=True)
    for name in ("ur5e.urdf", "capsules.yaml"):
        shutil.copy(shipped / name, own)
    robot = yaml.safe_load((shipped / "robot.yaml").read_text(encoding="utf-8"))
    robot |= {"id": NAME, "control_period_ms": PERIOD_MS}
    robot["parts"][0]["modes"] = ["joint_velocity", "cartesian_delta"]
    profile = robot["safety"]["sim"]
    for measured in profile["measured"].values():
        measured |= {"dead_band_per_tick": 1e-3, "stop_lag_s": 0.0, "standstill_per_s": 0.03}
    del profile["parts"]["arm"]["joint_position"]
    profile["parts"]["arm"] |= _arm_modes()
    profile["parts"]["gripper"]["gripper_position"]["slip_limit_rad"] = 0.02
    (own / "robot.yaml").write_text(yaml.safe_dump(robot, sort_keys=False), encoding="utf-8")
    return folder


def _arm_modes() -> dict[str, Any]:
    exact = {"gain": [1.0, 1.0], "source": SOURCE}
    return {
        "joint_velocity": {"step_limits": [3.14] * 6, "tracking_limits": [0.1] * 6, **exact},
        "cartesian_delta": {
            "frames": ["base_link"],
            "linear_limit_m": 0.02,
            "angular_limit_rad": 0.1,
            "linear_step_limit_m": 0.02,
            "angular_step_limit_rad": 0.1,
            "linear_tracking_m": 0.005,
            "angular_tracking_rad": 0.02,
            **exact,
        },
    }
