"""What a program asks the gate for when it claims parts."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError, expected
from fairlead.keys import check_name
from fairlead.messages import Claim
from fairlead.robot.manifest import RobotManifest


def claim_request(
    robot: RobotManifest,
    deployment: Deployment,
    parts: Sequence[str],
    source: str,
    task: str,
    by: str,
) -> Claim:
    """A claim of these parts; arguments as of `Robot.claim`. by: the person.

    Raises:
        ConfigError: no list of the robot's parts, a source of another's, or a task in no words.
    """
    _check(robot, deployment, parts, source, task)
    protocol = robot.profile(deployment.profile).protocol
    return Claim(
        source=source,
        skill=task or source,
        skill_hash=hashlib.sha256((task or source).encode()).digest(),
        robot_hash=robot.robot_hash,
        period_ns=robot.tick_period_ns,
        parts=robot.claimed_parts(parts),
        chunk_rate_hz=1e9 / robot.tick_period_ns,
        horizon_max=protocol.horizon_max,
        age_max_ticks=protocol.age_max_ticks,
        limits=(),
        by=by,
    )


def _check(
    robot: RobotManifest, deployment: Deployment, parts: Sequence[str], source: str, task: str
) -> None:
    valid, who = robot.part_names, f"robot {robot.id}"
    if isinstance(parts, str) or not isinstance(parts, Sequence) or not parts:
        raise ConfigError(expected(who, "a list of parts", repr(parts)[:80], valid))
    for part in parts:
        if part not in valid:
            raise ConfigError(expected(who, "a part to claim", repr(part)[:80], valid))
    if not isinstance(task, str) or not task.isprintable():
        raise ConfigError(expected(f"claim of {source}", "a task in words", repr(task)[:80]))
    check_name("source", source)
    if source in deployment.services:
        what = "a source that is none of its services"
        raise ConfigError(expected(f"deployment {deployment.id}", what, repr(source)))
