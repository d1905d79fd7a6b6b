"""Everything that is settled before a goal's first tick."""

from __future__ import annotations

import secrets
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256

from fairlead.messages import NO_TRACE, ClaimReply, Goal, HalStatus
from fairlead.robot.free_axes import FreeAxes
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.routes import Route


@dataclass(frozen=True)
class RunSetup:
    """One goal on one claim.

    Attributes:
        source: the runner's name in keys and chunks.
        deadline_ticks: ticks after the first observation; 0: none.
        stall_timeout_s: longest time without released rows, the policy's own time not counted.
        has_task: whether the simulator's own check decides about success.
        n_dof: commanded joints, which come first among the measured ones.
        periods: control periods for one row of the policy.
        camera_periods: ticks between frames, by camera.
        free_axes: by part, how a tool's free axes are filled in.
        handed_over: rows of the goal before may still act: its claim goes on as this one.
        first_seq: of the first chunk.
        trace_id: W3C trace id of the goal, 16 bytes; zeros: not traced.
    """

    source: str
    goal_id: int
    skill: SkillManifest
    routes: tuple[Route, ...]
    prompt: str
    deadline_ticks: int
    stall_timeout_s: float
    session: int
    robot_hash: bytes
    lockstep: bool
    has_task: bool
    claim_id: int
    epoch: int
    n_dof: int
    periods: int = 1
    camera_periods: Mapping[str, int] = field(default_factory=dict)
    free_axes: Mapping[int, FreeAxes] = field(default_factory=dict)
    handed_over: bool = False
    first_seq: int = 1
    trace_id: bytes = NO_TRACE[:16]

    def trace_of(self, seq: int) -> bytes:
        """Trace id and span id (8 bytes) of one chunk; the same bytes whenever it is asked."""
        if not any(self.trace_id):
            return NO_TRACE
        return self.trace_id + sha256(self.trace_id + seq.to_bytes(8, "big")).digest()[:8]

    @classmethod
    def of(
        cls,
        source: str,
        goal_id: int,
        goal: Goal,
        skill: SkillManifest,
        routes: tuple[Route, ...],
        hal: HalStatus,
        claim: ClaimReply,
        robot: RobotManifest,
        handed_over: bool = False,
        first_seq: int = 1,
    ) -> RunSetup:
        """Put together what the goal, the manifest, the HAL and the gate have said."""
        return cls(
            source=source,
            goal_id=goal_id,
            skill=skill,
            routes=routes,
            prompt=goal.prompt or skill.prompt,
            deadline_ticks=goal.deadline_ticks,
            stall_timeout_s=goal.stall_timeout_s,
            session=claim.session,
            robot_hash=hal.robot_hash,
            lockstep=hal.pacing == "lockstep",
            has_task=hal.has_task and skill.decided_by == "task",
            claim_id=claim.claim_id,
            epoch=claim.epoch,
            n_dof=robot.n_dof,
            free_axes=free_axes(routes, robot),
            periods=skill.control_periods(hal.period_ns) or 1,
            handed_over=handed_over,
            first_seq=first_seq,
            trace_id=secrets.token_bytes(16),
            camera_periods={camera.name: camera.period_ticks for camera in hal.cameras},
        )


def free_axes(routes: Sequence[Route], robot: RobotManifest) -> dict[int, FreeAxes]:
    """By the part's number, for each route that leaves axes free."""
    return {
        one.part: FreeAxes(robot, robot.parts[one.part], one.frame_id, one.columns)
        for one in routes
        if one.leaves_axes_free
    }
