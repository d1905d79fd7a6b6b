"""A robot's simulator behind its HAL backend, seen the way the gate sees it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fairlead.checked_model import checked_model
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.shipped_deployments import shipped_deployments
from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import Backend, ContactModel, PartCommand
from fairlead.hal.serve import hal_driver
from fairlead.messages import FloatArray
from fairlead.plugins import HALS
from fairlead.robot.description import description_tree
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.robot.tool_chain import ToolChain
from fairlead_tools.measure.rotations import Pose

_WHO = "robot measure"


@dataclass(frozen=True)
class Moment:
    """What is measured at the start of a tick.

    positions, velocities, efforts: of every measured joint, commanded ones first. tools: by the
    part with the most joints that carries it, T_root_tool [m]. base: x, y [m] and yaw [rad] of
    base_link in odom.
    """

    positions: FloatArray
    velocities: FloatArray
    efforts: FloatArray
    tools: Mapping[str, Pose]
    base: FloatArray


@dataclass(frozen=True)
class Tick:
    """One period: what was measured before it and after it, and what every part was told.

    kind: what the drive was. is_free: since the reset nothing of the robot touched anything but
    what touched at rest, and no arm joint was at the end of its range.
    """

    kind: str
    before: Moment
    after: Moment
    commands: Mapping[str, PartCommand]
    is_free: bool


class DrivenRobot:
    """One robot; every seed and every row of commands leads to the same numbers again.

    Args:
        robot: its folder under robots/.
        deployment: whose HAL is driven, with its options; None: the robot's first in lockstep.
        backend: another way to the robot than its HAL in here.

    Attributes:
        is_free: as in `Tick`, up to now.
        modes: of each part, those that this HAL can do.

    Raises:
        ConfigError: no deployment of the robot, or none whose HAL can be driven here.
    """

    def __init__(
        self, robot: str, deployment: Deployment | None = None, backend: Backend | None = None
    ) -> None:
        self.robot: RobotManifest = load_robot(robot)
        self.deployment = deployment or simulated_deployment(robot)
        self.profile = self.deployment.profile
        self.backend = backend or _backend(self.robot, self.deployment)
        self.period_s = self.robot.tick_period_ns * 1e-9
        self.chains = tool_chains(self.robot)
        self.is_free, self._touch_at_rest = True, frozenset[str]()
        told = {part.name: part.ranges for part in self.backend.describe().parts}
        self.modes = {
            part.name: tuple(
                mode
                for mode in part.control_modes
                if mode in [one.mode for one in told.get(part.name, ())]
            )
            for part in self.robot.parts
        }

    def reset(self, seed: int) -> Moment:
        """A new episode, held for one tick."""
        self.backend.reset(seed)
        self.backend.apply({})
        self.is_free, self._touch_at_rest = True, frozenset(self.contacts())
        return self.look()

    def step(self, kind: str, before: Moment, commands: Mapping[str, PartCommand]) -> Tick:
        """One period with these commands; ``before`` is what `look` says now."""
        self.backend.apply(commands)
        after = self.look()
        self.is_free = self.is_free and not self._is_hindered(after)
        return Tick(kind, before, after, commands, self.is_free)

    def look(self) -> Moment:
        """What is measured now."""
        found = self.backend.read()
        base = self.robot.base_frame
        pose = next(frame for frame in self.backend.transforms() if frame.child == base)
        z, w = pose.rotation_xyzw[2:]
        at = self.named(found.positions)
        return Moment(
            found.positions,
            found.velocities,
            found.efforts,
            {part: chain.pose(at) for part, chain in self.chains.items()},
            np.array([*pose.translation[:2], 2.0 * np.arctan2(z, w)]),
        )

    def named(self, positions: FloatArray) -> dict[str, float]:
        """Positions of all measured joints by name."""
        return dict(zip(self.robot.measured_joint_names, positions.tolist(), strict=True))

    def indices(self, part: str) -> list[int]:
        """Wire indices of a part's joints."""
        return [self.robot.joint_names.index(name) for name in self.robot.part(part).joints]

    def contacts(self) -> list[str]:
        """What of the robot touches what now; nothing where the HAL cannot say."""
        backend = self.backend
        return list(backend.contacts()) if isinstance(backend, ContactModel) else []

    def _is_hindered(self, now: Moment) -> bool:
        for index, joint in enumerate(self.robot.joints):
            is_bounded_arm = joint.role == "arm" and joint.has_bounds
            if is_bounded_arm and not joint.lower < now.positions[index] < joint.upper:
                return True
        return not self._touch_at_rest.issuperset(self.contacts())


def tool_chains(robot: RobotManifest) -> dict[str, ToolChain]:
    """Each tool once, by the part with the most joints that carries it."""
    tree, chains, carried = description_tree(robot), dict[str, ToolChain](), set[str]()
    for part in sorted(robot.parts, key=lambda one: -len(one.joints)):
        if part.end_effector is not None:
            frame = robot.end_effector(part.end_effector).tool_frame
            if frame not in carried:
                carried.add(frame)
                chains[part.name] = ToolChain(tree, frame)
    return chains


def simulated_deployment(robot: str) -> Deployment:
    """The first deployment of a robot whose HAL is a simulator, in lockstep if one is.

    Raises:
        ConfigError: there is none.
    """
    found = list(shipped_deployments(robot))
    here = [one for _, one in found if _is_simulated(one)]
    waiting = [one for one in here if one.pacing == "lockstep"]
    if here:
        return (waiting or here)[0]
    names = [name for name, _ in found]
    what = f"a deployment of robot {robot} whose HAL is a simulator (--deployment)"
    raise ConfigError(expected(_WHO, what, ", ".join(names) or "none"))


def _is_simulated(deployment: Deployment) -> bool:
    run = deployment.services[deployment.hal].run
    return run in HALS.names() and hal_driver(run, _WHO).simulator


def _backend(robot: RobotManifest, deployment: Deployment) -> Backend:
    service, who = deployment.services[deployment.hal], f"{_WHO}: {deployment.hal}"
    if not service.run:
        raise ConfigError(
            f"{who} is a command of its own, which is measured while it runs: --running"
        )
    driver = hal_driver(service.run, who)
    # Neither pictures nor traces are needed, and a camera is a process of its own.
    told = {k: v for k, v in service.options.items() if k not in ("cameras", "trace")}
    options = checked_model(f"{who}: options", driver.options, told)
    return driver.equip(robot, deployment.profile, options).backend
