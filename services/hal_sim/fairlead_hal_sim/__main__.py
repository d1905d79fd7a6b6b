"""The simulated HAL: ``python -m fairlead_hal_sim --deployment FILE --service NAME ...``."""

from __future__ import annotations

import logging
import secrets
import sys

from fairlead.hal.backend import Backend
from fairlead.hal.camera_feed import CameraFeed
from fairlead.hal.host import HalHost, HostSettings
from fairlead.hal.identity import identity_of
from fairlead.hal.kinematic_backend import KinematicBackend
from fairlead.hal.motion_log import MotionLog
from fairlead.hal.trace_source import TraceSource
from fairlead.robot import RobotManifest, load_robot
from fairlead.service import ServiceContext, announce_ready, run_service
from fairlead_hal_sim.camera_process import start_camera_process
from fairlead_hal_sim.hal_options import HalSimOptions, read_options
from fairlead_hal_sim.one_hal import lock_state_folder, refuse_second_hal


def body(context: ServiceContext) -> None:
    """Build the backend and run the host until the process is asked to stop."""
    deployment = context.deployment
    options = read_options(context.name, context.options)
    lock = lock_state_folder(context.name, context.state_dir)
    refuse_second_hal(context.name, context.bus, deployment.keys)
    robot = load_robot(deployment.robot)
    backend, trace = _make_backend(options, robot, deployment.profile)
    feed = _start_cameras(options, robot)
    session = secrets.randbits(63) + 1
    host = HalHost(
        HostSettings(context.name, deployment.keys, deployment.pacing, session),
        identity_of(robot, deployment.profile, deployment.id),
        backend,
        context.bus,
        MotionLog(context.state_dir, session, options.trace),
        feed,
        trace,
    )
    logging.getLogger(context.name).info(
        "session %x, %s, %s backend", session, deployment.pacing, options.backend
    )
    announce_ready(context)
    host.run(context.stopping)
    lock.close()


def _make_backend(
    options: HalSimOptions, robot: RobotManifest, profile: str
) -> tuple[Backend, TraceSource]:
    if options.backend == "kinematic":
        kinematic = KinematicBackend(robot, profile, options.frames)
        kinematic.reset(options.seed)
        return kinematic, kinematic
    # Imported late: robosuite takes seconds, and the kinematic backend does without.
    from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
    from fairlead_hal_sim.robosuite_trace import RobosuiteTrace

    backend = RobosuiteBackend(options, robot.tick_period_ns)
    return backend, RobosuiteTrace(backend)


def _start_cameras(options: HalSimOptions, robot: RobotManifest) -> CameraFeed | None:
    if options.backend == "kinematic" or not options.cameras:
        return None
    return start_camera_process(options, 1e9 / robot.tick_period_ns)


if __name__ == "__main__":
    sys.exit(run_service("fairlead_hal_sim", body))
