"""What the assembler does with each message: pure, no transport, no clock.

At joints n it computes the links' poses and then, for every wanted skill, the layout of
n. Where a transform of n has not arrived yet it waits for it: until joints n+1 come, or
in lockstep, where n is repeated while the world waits, until its second repeat. Then the
fault is published, unless n+1 can be answered: one good layout is worth more than the
news that an older one was lost. What waiting cannot mend (a loop, a frame that its
publisher sends no more) is published at once. Before the first joint state nothing is.

Whose session it follows is the gate's to decide; before its first lease, any newer one's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import pinocchio as pin

from fairlead.errors import LayoutError, MessageError
from fairlead.messages import (
    JointState,
    Lease,
    Transform,
    TransformBatch,
    encode,
    floats,
    pack_floats,
)
from fairlead.robot.manifest import RobotManifest
from fairlead_state_assembler.branches import HISTORY_TICKS
from fairlead_state_assembler.forward_kinematics import ForwardKinematics
from fairlead_state_assembler.joint_positions import JointPositions
from fairlead_state_assembler.pose_decoding import SE3
from fairlead_state_assembler.publishers import Publishers
from fairlead_state_assembler.skill_view import Moment, SkillView
from fairlead_state_assembler.transform_buffer import TransformBuffer

REPEATS_BEFORE_FAULT = 2


class LinkTransforms:
    """Where the links are at one tick; encoded when asked for, after the layouts have gone."""

    def __init__(
        self, moment: Moment, base: str, frames: Mapping[str, int], poses: Sequence[SE3]
    ) -> None:
        self._moment, self._base, self._frames, self._poses = moment, base, frames, poses

    @cached_property
    def payload(self) -> bytes:
        """The encoded `TransformBatch`."""
        transforms = []
        for frame, place in self._frames.items():
            numbers = pack_floats(pin.SE3ToXYZQUAT(self._poses[place]))
            transforms.append(
                Transform(
                    parent=self._base,
                    child=frame,
                    translation=numbers[:24],
                    rotation_xyzw=numbers[24:],
                )
            )
        return encode(
            TransformBatch(
                session=self._moment.session,
                tick=self._moment.tick,
                is_static=False,
                transforms=tuple(transforms),
            )
        )


class Output(NamedTuple):
    """Something to publish: link transforms (``skill`` None) or one skill's layout."""

    skill: str | None
    content: bytes | LinkTransforms

    @property
    def payload(self) -> bytes:
        """Its bytes."""
        return self.content if isinstance(self.content, bytes) else self.content.payload


class AssemblerCore:
    """State of the assembler between messages. Not thread-safe.

    Args:
        robot: whose joint states these are.
        publishers: who sends which transforms.
        max_age_ticks: see `TransformBuffer`.
    """

    def __init__(
        self,
        robot: RobotManifest,
        publishers: Publishers,
        max_age_ticks: Mapping[str, int] | None = None,
    ) -> None:
        self._robot = robot
        self._kinematics = ForwardKinematics(robot)
        owners = publishers.of_frames(self._kinematics.base_frame, self._kinematics.frames)
        self._buffer = TransformBuffer(max_age_ticks, owners, publishers.hal)
        self._index = {name: i for i, name in enumerate(robot.measured_joint_names)}
        self._views: dict[str, SkillView] = {}
        self._moment: Moment | None = None
        self._repeats = 0
        self._links: list[Output] = []  # of the newest tick
        self._session = 0  # the gate's, 0 before its first lease that names one
        self._stranger = 0  # newest other session in a joint state
        self._stranger_stays = False  # the followed one was heard after it

    def want(self, view: SkillView) -> list[Output]:
        """Start assembling for a skill, with the current tick if there is one."""
        view = self._views.setdefault(view.skill, view)
        return self._answers([view], give_up=view.refusal is not None)

    def unwant(self, skill: str) -> None:
        """Stop assembling for a skill."""
        self._views.pop(skill, None)

    def on_lease(self, lease: Lease) -> None:
        """Take the gate's word for whose joint states these are, 0 is none, and for the tick.

        What claims to be far later is nobody's, or the gate hears less than this does.
        """
        if lease.session == self._session and lease.state_tick:
            latest = lease.state_tick + HISTORY_TICKS
            self._buffer.discard_after(latest)
            if self._moment is not None and self._moment.tick > latest:
                self._moment = None
        if lease.session in (0, self._session):
            return
        self._session = lease.session
        self._stranger, self._stranger_stays = 0, False
        self._buffer.follow(lease.session)

    def on_transforms(self, batch: TransformBatch, publisher: str) -> list[Output]:
        """Take transforms; whatever waited for them is answered now.

        Args:
            publisher: see `TransformBuffer.add_batch`.

        Raises:
            MessageError: for numbers that are no transform; nothing of it is taken.
        """
        if not self._buffer.add_batch(batch, publisher):
            return []
        if self._moment is not None and self._moment.session != batch.session:
            self._moment = None  # a new HAL session: wait for its first joint state
        return self._answers(self._unanswered(), give_up=False)

    def on_joints(self, state: JointState) -> list[Output]:
        """Take a joint state: a new tick, a repeat of the current one, or an old one.

        Raises:
            MessageError: if its joints are not this robot's, or another HAL sends beside the one
                that the gate follows; nothing of it is taken.
        """
        self._refuse_stranger(state.session)
        if state.episode_tick > state.tick:
            raise MessageError(
                f"state/joints: tick {state.tick}: expected an episode that has begun, "
                f"got {state.episode_tick}"
            )
        if state.robot_hash != self._robot.robot_hash:
            raise MessageError(
                f"state/joints: expected robot {self._robot.id} "
                f"({self._robot.robot_hash.hex()[:12]}), got {state.robot_hash.hex()[:12]}; "
                "the HAL runs with another robot.yaml"
            )
        positions = floats(state.positions)
        if len(positions) != len(self._index):
            raise MessageError(
                f"state/joints: expected {len(self._index)} positions, got {len(positions)}"
            )
        velocities = floats(state.velocities)
        if len(velocities) != len(positions):
            raise MessageError(
                f"state/joints: expected {len(positions)} velocities, got {len(velocities)}"
            )
        if not self._buffer.enter(state.session, state.episode_tick):
            return []
        now = self._moment
        if now is not None and now.session == state.session:
            if state.tick == now.tick:
                return self._repeat()
            if state.tick < now.tick:
                return []
        waiting = self._unanswered()
        late = self._answers(waiting, give_up=True) if waiting else []
        joints = JointPositions(self._index, positions, velocities)
        self._moment = Moment(state.session, state.tick, state.episode_tick, joints)
        new = self._new_tick(self._moment, self._kinematics.poses(positions))
        if not late:
            return new
        unanswered = {view.skill for view in self._unanswered()}
        return [*(output for output in late if output.skill in unanswered), *new]

    def _refuse_stranger(self, session: int) -> None:
        """A HAL that takes over from one that is gone is none: the gate's next lease names it."""
        if session == self._session:
            self._stranger_stays = self._stranger != 0
        elif session == self._stranger and self._stranger_stays:
            raise MessageError(
                f"state/joints: expected session {self._session:016x}, the HAL that the gate "
                f"follows, got {session:016x} beside it; another HAL runs under this robot's keys"
            )
        elif self._session and session != self._stranger:
            self._stranger, self._stranger_stays = session, False

    def _new_tick(self, moment: Moment, poses: Sequence[SE3]) -> list[Output]:
        base, frames = self._kinematics.base_frame, self._kinematics.frames
        self._buffer.add_links(base, frames, poses, moment.tick)
        self._links = [Output(None, LinkTransforms(moment, base, frames, poses))]
        self._repeats = 0
        views = list(self._views.values())
        for view in views:
            view.answer = None
        return [*self._answers(views, give_up=False), *self._links]

    def _repeat(self) -> list[Output]:
        """The tick again: the identical bytes again, and faults once waiting is over."""
        self._repeats += 1
        again = [
            Output(view.skill, view.answer)
            for view in self._views.values()
            if view.answer is not None
        ]
        give_up = self._repeats >= REPEATS_BEFORE_FAULT
        late = self._answers(self._unanswered(), give_up=give_up)
        return [*again, *late, *self._links]

    def _unanswered(self) -> list[SkillView]:
        return [view for view in self._views.values() if view.answer is None]

    def _answers(self, views: list[SkillView], *, give_up: bool) -> list[Output]:
        """Layouts that can be assembled now; for the others what is known to be wrong.

        Args:
            give_up: nothing that is missing is waited for any longer.
        """
        if self._moment is None:
            return []
        outputs = []
        for view in views:
            error: LayoutError | None = None
            if view.answer is None:
                error = view.try_answer(self._moment, self._buffer.at(self._moment.tick))
            if view.answer is not None:
                outputs.append(Output(view.skill, view.answer))
            elif error is not None and (give_up or error.is_certain):
                outputs.append(Output(view.skill, view.fault_message(self._moment, error)))
        return outputs
