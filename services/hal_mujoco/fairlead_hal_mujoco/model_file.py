"""Loading the MJCF file of a robot."""

from __future__ import annotations

from pathlib import Path

import mujoco

from fairlead.errors import ConfigError, expected


def load_model(path: Path, period_ns: int) -> tuple[mujoco.MjModel, int]:
    """The compiled model and its physics steps per control period.

    Args:
        period_ns: control period of the robot [ns].

    Raises:
        ConfigError: no such file, MuJoCo's own complaint about it, or a timestep that does
            not divide the control period.
    """
    if not path.is_file():
        raise ConfigError(f"hal_mujoco: expected an MJCF file, got none at {path}")
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise ConfigError(f"hal_mujoco: {path}: {' '.join(str(error).split())}") from None
    period_s = period_ns * 1e-9
    steps = round(period_s / model.opt.timestep)
    if steps < 1 or abs(steps * model.opt.timestep - period_s) > 1e-9:
        raise ConfigError(
            expected(
                f"hal_mujoco: {path}: timestep",
                f"a whole part of the control period of {period_s:g} s",
                f"{model.opt.timestep:g} s",
            )
        )
    # MuJoCo would put a diverged simulation back to its start, and nobody would notice.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    return model, steps
