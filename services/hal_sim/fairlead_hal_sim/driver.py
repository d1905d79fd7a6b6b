"""The simulated HAL, as deployment files name it: ``run: hal_sim``."""

from __future__ import annotations

from fairlead.hal.backend import CameraFeed
from fairlead.hal.process import Equipment, HalDriver
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_sim.camera_process import start_camera_process
from fairlead_hal_sim.options import HalSimOptions


def _equip(robot: RobotManifest, profile: str, options: HalSimOptions) -> Equipment:
    # Imported late: robosuite takes seconds, and options that do not fit are refused without it.
    from fairlead.hal.setpoints import check_command_frame

    # robosuite's base controller turns what it is told against the measured yaw.
    check_command_frame(robot, profile, "hal_sim", "against_yaw")
    from fairlead_hal_sim.environment import leave_out_observations
    from fairlead_hal_sim.robosuite_backend import RobosuiteBackend, RobosuiteTrace

    backend = RobosuiteBackend(options, robot.tick_period_ns, robot)
    leave_out_observations(backend.env)
    trace = RobosuiteTrace(backend) if options.trace else None
    return Equipment(backend, _start_cameras(options, robot), trace, backend.frames(robot))


def _start_cameras(options: HalSimOptions, robot: RobotManifest) -> CameraFeed | None:
    if not options.cameras:
        return None
    return start_camera_process(options, 1e9 / robot.tick_period_ns)


DRIVER = HalDriver(HalSimOptions, _equip, simulator=True)
