"""The simulated HAL: ``python -m fairlead_hal_sim --deployment FILE --service NAME ...``."""

from __future__ import annotations

import sys

from fairlead.hal.camera_feed import CameraFeed
from fairlead.hal.kinematic_backend import KinematicBackend
from fairlead.hal.process import Equipment, run_hal
from fairlead.robot.manifest import RobotManifest
from fairlead.service import ServiceContext, run_service
from fairlead_hal_sim.camera_process import start_camera_process
from fairlead_hal_sim.hal_options import HalSimOptions, read_options


def body(context: ServiceContext) -> None:
    """Build the backend and run the host until the process is asked to stop."""
    options, profile = read_options(context.name, context.options), context.deployment.profile
    run_hal(context, lambda robot: _equip(options, robot, profile), what=options.backend)


def _equip(options: HalSimOptions, robot: RobotManifest, profile: str) -> Equipment:
    if options.backend == "kinematic":
        kinematic = KinematicBackend(robot, profile, options.frames)
        kinematic.reset(options.seed)
        return Equipment(kinematic, trace=kinematic if options.trace else None)
    # Imported late: robosuite takes seconds, and the kinematic backend does without.
    from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
    from fairlead_hal_sim.robosuite_trace import RobosuiteTrace

    backend = RobosuiteBackend(options, robot.tick_period_ns, robot)
    trace = RobosuiteTrace(backend) if options.trace else None
    return Equipment(backend, _start_cameras(options, robot), trace, backend.frames(robot))


def _start_cameras(options: HalSimOptions, robot: RobotManifest) -> CameraFeed | None:
    if not options.cameras:
        return None
    return start_camera_process(options, 1e9 / robot.tick_period_ns)


if __name__ == "__main__":
    sys.exit(run_service("fairlead_hal_sim", body))
