"""A bus with the servos of one calibration, and no others."""

from __future__ import annotations

from pathlib import Path

from fairlead.errors import ConfigError
from fairlead_hal_so101.calibration import Calibration
from fairlead_hal_so101.servo_bus import ServoBus

_POSITION_MODE = 0


def calibrated_bus(
    port: str, calibration: Calibration, file: Path, answer_timeout_s: float, who: str
) -> ServoBus:
    """Open a port, and compare its servos with the calibration.

    Args:
        file: that the calibration is from, for errors.
        who: complains in errors.

    Raises:
        ConfigError: what is on the port is not the arm that was calibrated.
        HardwareError: it does not answer.
    """
    names = {servo.id: servo.joint for servo in calibration.servos}
    bus = ServoBus(port, names, answer_timeout_s, who)
    try:
        bus.check_servos()
        for one in calibration.servos:
            wanted = {
                "operating_mode": _POSITION_MODE,
                "homing_offset": one.homing_offset_steps,
                "min_position_limit": one.lower_steps,
                "max_position_limit": one.upper_steps,
            }
            for name, value in wanted.items():
                if (got := bus.get(one.id, name)) != value:
                    raise ConfigError(
                        f"{who}: servo {bus.named([one.id])}: expected {name} {value} ({file}), "
                        f"got {got}: another arm, or calibrated elsewhere; fairlead calibrate so101"
                    )
    except BaseException:
        bus.close()
        raise
    return bus
