"""The plain MuJoCo HAL: ``python -m fairlead_hal_mujoco --deployment FILE --service NAME ...``."""

from __future__ import annotations

import sys

from fairlead.checked_model import checked_model
from fairlead.hal.process import Equipment, run_hal
from fairlead.robot.manifest import RobotManifest
from fairlead.service import ServiceContext, run_service
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from fairlead_hal_mujoco.options import MujocoOptions


def body(context: ServiceContext) -> None:
    """Load the model and run the host until the process is asked to stop."""
    options = checked_model(f"service {context.name}: options", MujocoOptions, context.options)

    def equip(robot: RobotManifest) -> Equipment:
        backend = MujocoBackend(robot, context.deployment.profile, options)
        trace = backend if options.trace else None
        return Equipment(backend, trace=trace, frames=backend.frames())

    run_hal(context, equip, what="mujoco")


if __name__ == "__main__":
    sys.exit(run_service("fairlead_hal_mujoco", body))
