"""Options and profiles that `run: hal_sim` refuses."""

from __future__ import annotations

import pytest

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError
from fairlead.robot.manifest import load_robot
from fairlead_hal_sim.driver import DRIVER
from fairlead_hal_sim.options import HalSimOptions


def test_a_backend_is_refused_naming_the_hal_to_run_instead() -> None:
    with pytest.raises(ConfigError) as caught:
        checked_model("", HalSimOptions, {"backend": "kinematic"})
    text = str(caught.value)
    assert "backend: expected none, as `run` chooses the HAL, got 'kinematic' (valid: " in text
    assert "run: hal_kinematic" in text


def test_a_profile_whose_base_is_told_along_odom_is_not_this_simulators() -> None:
    what = "hal_sim: panda_mobile: safety.hardware.base.command_frame: expected against_yaw"
    with pytest.raises(ConfigError, match=f"^{what}, got odom"):
        DRIVER.equip(load_robot("panda_mobile"), "hardware", HalSimOptions())
