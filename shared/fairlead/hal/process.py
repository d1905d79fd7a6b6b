"""What every HAL process does around its backend: one robot, one folder, one host."""

from __future__ import annotations

import logging
import secrets
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import BaseModel

from fairlead.deploy.sockets import socket_path
from fairlead.hal.backend import Backend, CameraFeed, FrameModel, TraceSource
from fairlead.hal.frame_check import check_frames
from fairlead.hal.host import SUSPENDED_NS, HalHost
from fairlead.hal.identity import HostSettings, identity_of
from fairlead.hal.one_hal import hold_robot, lock_state_folder, refuse_second_hal
from fairlead.hal.plan_executor import MotionLog
from fairlead.messages import ResetEpisode
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.service import ServiceContext, announce_ready, run_in_thread

__all__ = ["Equipment", "HalDriver", "run_hal"]

RESET_S = 60.0  # what who asks waits for; the desk itself gives up before

Options = TypeVar("Options", bound=BaseModel)


@dataclass(frozen=True)
class Equipment:
    """What one HAL brings to the host.

    feed: renders camera frames elsewhere; None for no cameras.
    trace: shows a simulator's state; None records none.
    frames: the robot's own model of where its frames are, compared with its description before
    the first tick; None: it has none.
    """

    backend: Backend
    feed: CameraFeed | None = None
    trace: TraceSource | None = None
    frames: FrameModel | None = None


@dataclass(frozen=True)
class HalDriver(Generic[Options]):
    """A HAL behind an entry point in ``fairlead.hals``: a deployment file names it in ``run``.

    options: the model of the ``options`` it takes there, pydantic with ``extra="forbid"``.
    equip: makes the equipment from the robot, the name of the safety profile that holds, and the
        checked options. Called once it is sure that this is the robot's only HAL; what takes long
        to import is best imported in there.
    realtime_only: its robot is real and waits for nobody: pacing ``lockstep`` is refused, and a
        profile with a simulator's limits is warned of.
    simulator: nothing real can move: ``fairlead hal check`` drives it at full size without asking.
    """

    options: type[Options]
    equip: Callable[[RobotManifest, str, Options], Equipment]
    realtime_only: bool = False
    simulator: bool = False


async def run_hal(
    context: ServiceContext, equip: Callable[[RobotManifest], Equipment], *, what: str
) -> None:
    """Build the backend and run the host until the process is asked to stop.

    One thread of its own, ``tick``, makes the equipment and calls it until the end.

    Args:
        equip: makes the equipment, once it is sure that this is the robot's only HAL.
        what: the HAL's name, for the log.

    Raises:
        ConfigError: if the robot has a HAL already, or the backend does not fit it; if frames are
            elsewhere than the robot's description has them.
    """
    keys, socket = context.deployment.keys, socket_path(context.deployment.listen(context.name))
    with (
        lock_state_folder(context.name, context.state_dir),
        hold_robot(context.name, keys, Path(socket).parent if socket else None),
    ):
        await run_in_thread(context, "tick", lambda ending: _tick(context, equip, what, ending))


def _tick(
    context: ServiceContext,
    equip: Callable[[RobotManifest], Equipment],
    what: str,
    ending: threading.Event,
) -> None:
    deployment = context.deployment
    session = secrets.randbits(63) + 1
    refuse_second_hal(context.name, context.bus, deployment.keys, session)
    robot = load_robot(deployment.robot)
    identity = identity_of(robot, deployment.profile, deployment.id)  # before anything has power
    equipment = equip(robot)
    log = logging.getLogger(context.name)
    settings = HostSettings(
        context.name, deployment.keys, deployment.pacing, session, deployment.localiser
    )
    motion = MotionLog(context.state_dir, session, equipment.trace is not None)
    try:
        if equipment.frames is not None:
            here = equipment.backend.read().positions
            log.info(check_frames(robot, equipment.frames, here, context.name, stands="the start"))
        host = HalHost(
            settings, identity, equipment.backend, context.bus, motion, equipment.feed,
            equipment.trace, suspended=suspended_ns, pulse=context.pulse,
        )  # fmt: skip
    except BaseException:
        equipment.backend.close()
        raise
    log.info("session %016x, %s, %s", session, deployment.pacing, what)
    key = deployment.keys.hal_command("reset_episode")
    people, serve = deployment.parties.people, context.queries.serve_command
    resets = serve(key, ResetEpisode, host.resets.handle, RESET_S, people)
    announce_ready(context)
    host.run(ending)
    for one in resets:
        one.undeclare()


def suspended_ns() -> int:
    """How long this computer has been suspended, in all: the monotonic clock stands still then."""
    while True:
        before_ns = time.monotonic_ns()
        counted_ns = time.clock_gettime_ns(time.CLOCK_BOOTTIME)
        if time.monotonic_ns() - before_ns < SUSPENDED_NS:  # else this process had to wait
            return counted_ns - before_ns
