"""The messages behind the golden bytes: what every codec of this project must agree on.

Each type has one ``rich`` instance in which no two fields are equal, so that a codec that
swaps two fields fails, and edge instances where the encoding changes width or shape.
``MESSAGES`` maps the name of the file (without ``.bin``) to the message.
"""

from __future__ import annotations

from fairlead.messages import (
    NO_HASH,
    NO_TRACE,
    Acted,
    ActionChunk,
    ActionPart,
    Arm,
    ArmReply,
    Cancel,
    Claim,
    ClaimInfo,
    ClaimReply,
    Decision,
    Disarm,
    Done,
    GateState,
    GateStatus,
    Goal,
    GoalAccepted,
    GoalFeedback,
    GoalResult,
    Grant,
    HalCamera,
    HalPart,
    HalStatus,
    Heartbeat,
    Hold,
    Image,
    JointState,
    LayoutFault,
    LayoutState,
    Lease,
    LimitOverride,
    Message,
    ModeRange,
    Outcome,
    Refusal,
    Release,
    Reset,
    ResetEpisode,
    ResetEpisodeReply,
    SafeChunk,
    StatusQuery,
    StopLevel,
    TaskState,
    Transform,
    TransformBatch,
    Verdict,
    pack_floats,
)
from fairlead.modes import ControlMode

U32_MAX = 2**32 - 1
U64_MAX = 2**64 - 1
TINY = 5e-324  # the smallest denormal
HUGE = 1.7976931348623157e308

ROBOT_HASH = bytes(range(32))
CONFIG_HASH = bytes(range(32, 64))
SKILL_HASH = bytes(range(64, 96))
TRACE = bytes(range(200, 224))

SESSION = 0x1122334455667788
EPOCH = 0x2233445566778899
CLAIM = 0x33445566778899AA
VERDICT = 0x445566778899AABB
GOAL = 0x5566778899AABBCC
STOP = 0x66778899AABBCCDD

JOINTS = (
    "base_x",
    "base_y",
    "base_yaw",
    *(f"panda_joint{n}" for n in range(1, 8)),
    "panda_gripper",
)
PASSIVE = ("panda_finger_joint1", "panda_finger_joint2", "torso_height")


def ramp(count: int, start: float, step: float = 0.125) -> bytes:
    """A float64 block start, start + step, ...: every number of it is distinct."""
    return pack_floats([start + step * k for k in range(count)])


def arm_delta(rows: int, first: float = 0.01) -> ActionPart:
    """``rows`` of the arm's cartesian_delta."""
    return ActionPart(
        part=0,
        mode=ControlMode.CARTESIAN_DELTA,
        frame_id="base_link",
        values=ramp(6 * rows, first, 0.001),
        active=(),
    )


def base_velocity(rows: int) -> ActionPart:
    """``rows`` of the base's joint_velocity: three active joints of eleven, zeros elsewhere."""
    one_row = [0.25, -0.5, 0.75] + [0.0] * 8
    return ActionPart(
        part=2,
        mode=ControlMode.JOINT_VELOCITY,
        frame_id="",
        values=pack_floats(one_row * rows),
        active=(0, 1, 2),
    )


def composite(rows: int) -> ActionPart:
    """``rows`` of the composite switch."""
    return ActionPart(
        part=3,
        mode=ControlMode.COMPOSITE_MODE,
        frame_id="",
        values=pack_floats([-1.0] * rows),
        active=(),
    )


def gripper(rows: int) -> ActionPart:
    """``rows`` of the gripper's opening [m]."""
    return ActionPart(
        part=1,
        mode=ControlMode.GRIPPER_POSITION,
        frame_id="",
        values=ramp(rows, 0.01, 0.005),
        active=(),
    )


STATE = {
    "JointState": JointState(
        session=SESSION,
        tick=1001,
        episode_tick=7,
        stamp_ns=123_456_789_012,
        positions=ramp(14, -1.5),
        velocities=ramp(14, 0.0625),
        efforts=ramp(14, 20.0),
        acted=(
            Acted(hold=Hold.NONE, verdict_id=VERDICT, row=5),
            Acted(hold=Hold.NO_ROW, verdict_id=0, row=0),
            Acted(hold=Hold.STOPPED, verdict_id=0, row=0),
            Acted(hold=Hold.STARTING, verdict_id=0, row=0),
        ),
        robot_hash=ROBOT_HASH,
    ),
    "JointState.empty": JointState(
        session=0,
        tick=0,
        episode_tick=0,
        stamp_ns=0,
        positions=b"",
        velocities=b"",
        efforts=b"",
        acted=(),
        robot_hash=NO_HASH,
    ),
    "JointState.extremes": JointState(
        session=U64_MAX,
        tick=U64_MAX,
        episode_tick=2**63,
        stamp_ns=2**32,
        positions=pack_floats([0.0, -0.0, TINY, -TINY, HUGE, -HUGE]),
        velocities=pack_floats([float("inf"), float("-inf"), float("nan")]),
        efforts=pack_floats([2.2250738585072014e-308, 1e6, -1e6]),
        acted=(Acted(hold=255, verdict_id=U64_MAX, row=U32_MAX),),
        robot_hash=b"\xff" * 32,
    ),
    "TransformBatch": TransformBatch(
        session=SESSION,
        tick=1001,
        is_static=False,
        transforms=(
            Transform(
                parent="odom",
                child="base_link",
                translation=pack_floats([1.0, 2.0, 3.0]),
                rotation_xyzw=pack_floats([0.5, -0.5, 0.5, -0.5]),
            ),
            Transform(
                parent="base_link",
                child="grip_site",
                translation=pack_floats([0.25, 0.125, 1.0625]),
                rotation_xyzw=pack_floats([0.0, 0.0, 0.0, 1.0]),
            ),
        ),
    ),
    "TransformBatch.empty": TransformBatch(session=SESSION, tick=1, is_static=True, transforms=()),
    "Image": Image(
        session=SESSION,
        tick=1002,
        camera="front",
        width=3,
        height=2,
        encoding_name="rgb8",
        data=bytes(range(100, 118)),
    ),
    "Image.empty": Image(
        session=SESSION,
        tick=1002,
        camera="",
        width=0,
        height=0,
        encoding_name="jpeg",
        data=b"",
    ),
    "TaskState": TaskState(
        session=SESSION,
        tick=1003,
        episode_tick=7,
        success=True,
        metrics=(("object_to_gripper_m", 0.0875), ("object_height_m", 1.0625)),
    ),
    "TaskState.empty": TaskState(
        session=SESSION, tick=1, episode_tick=1, success=False, metrics=()
    ),
    "HalStatus": HalStatus(
        session=SESSION,
        robot="panda_mobile",
        robot_hash=ROBOT_HASH,
        pacing="lockstep",
        period_ns=50_000_000,
        tick=1004,
        episode_tick=7,
        state="ready",
        detail="episode of seed 3",
        joints=JOINTS,
        passive_joints=PASSIVE,
        parts=(
            HalPart(
                name="arm",
                simulator_part="right",
                joints=JOINTS[3:10],
                ranges=(
                    ModeRange(
                        mode=ControlMode.CARTESIAN_DELTA,
                        lower=pack_floats([-0.05] * 3 + [-0.5] * 3),
                        upper=pack_floats([0.05] * 3 + [0.5] * 3),
                    ),
                ),
            ),
            HalPart(
                name="base",
                simulator_part="base",
                joints=JOINTS[:3],
                ranges=(
                    ModeRange(
                        mode=ControlMode.JOINT_VELOCITY,
                        lower=pack_floats([-1.0, -1.0, -1.5]),
                        upper=pack_floats([1.0, 1.0, 1.5]),
                    ),
                ),
            ),
        ),
        simulator_order=("right", "torso", "base", "right_gripper"),
        cameras=(HalCamera(name="front", width=128, height=96, period_ticks=4),),
        has_task=True,
        overruns=2,
    ),
    "HalStatus.empty": HalStatus(
        session=1,
        robot="desk_arm",
        robot_hash=ROBOT_HASH,
        pacing="realtime",
        period_ns=U64_MAX,
        tick=1,
        episode_tick=1,
        state="fault",
        detail="",
        joints=(),
        passive_joints=(),
        parts=(HalPart(name="arm", simulator_part="", joints=(), ranges=()),),
        simulator_order=(),
        cameras=(),
        has_task=False,
        overruns=0,
    ),
    "LayoutState": LayoutState(
        session=SESSION,
        tick=1005,
        episode_tick=7,
        oldest_tick=1004,
        skill="oracle-counter-to-cabinet",
        skill_hash=SKILL_HASH,
        layout="mobile_pick_30d",
        values=ramp(30, -2.0),
        fault=None,
    ),
    "LayoutState.fault": LayoutState(
        session=SESSION,
        tick=1005,
        episode_tick=7,
        oldest_tick=1000,
        skill="oracle-counter-to-cabinet",
        skill_hash=SKILL_HASH,
        layout="mobile_pick_30d",
        values=None,
        fault=LayoutFault(
            kind="missing_frame",
            name="object",
            parent="odom",
            age_ticks=-1,
            text="layout mobile_pick_30d: no transform odom -> object",
        ),
    ),
}

ACTION = {
    "ActionChunk": ActionChunk(
        robot_hash=ROBOT_HASH,
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        seq=42,
        goal_id=GOAL,
        obs_tick=1006,
        oldest_tick=1002,
        start_tick=1007,
        horizon=2,
        parts=(arm_delta(2), gripper(2), base_velocity(2), composite(2)),
        trace=TRACE,
    ),
    "ActionChunk.one_row": ActionChunk(
        robot_hash=ROBOT_HASH,
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        seq=1,
        goal_id=0,
        obs_tick=1,
        oldest_tick=1,
        start_tick=1,
        horizon=1,
        parts=(composite(1),),
        trace=NO_TRACE,
    ),
    "ActionChunk.empty": ActionChunk(
        robot_hash=NO_HASH,
        session=0,
        epoch=0,
        claim_id=0,
        source="",
        seq=0,
        goal_id=0,
        obs_tick=0,
        oldest_tick=0,
        start_tick=0,
        horizon=0,
        parts=(),
        trace=NO_TRACE,
    ),
    "ActionChunk.full_horizon": ActionChunk(
        robot_hash=ROBOT_HASH,
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner-" + "x" * 40,
        seq=U64_MAX,
        goal_id=U64_MAX,
        obs_tick=2**32,
        oldest_tick=2**32 - 1,
        start_tick=2**32 + 1,
        horizon=64,
        parts=(arm_delta(64, -0.02), gripper(64), base_velocity(64), composite(64)),
        trace=TRACE,
    ),
    "ActionChunk.extremes": ActionChunk(
        robot_hash=ROBOT_HASH,
        session=U64_MAX,
        epoch=U64_MAX,
        claim_id=U64_MAX,
        source="é€😀",
        seq=127,
        goal_id=128,
        obs_tick=255,
        oldest_tick=256,
        start_tick=65_536,
        horizon=U32_MAX,
        parts=(
            ActionPart(
                part=255,
                mode=255,
                frame_id="f" * 256,
                values=pack_floats([float("nan"), float("inf"), float("-inf"), TINY, HUGE, -0.0]),
                active=tuple(range(16)),
            ),
        ),
        trace=TRACE,
    ),
    "SafeChunk": SafeChunk(
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        verdict_id=VERDICT,
        judged_tick=1006,
        first_tick=1007,
        horizon=2,
        after=Acted(hold=Hold.NONE, verdict_id=VERDICT - 1, row=7),
        parts=(arm_delta(2), gripper(2), base_velocity(2), composite(2)),
    ),
    "SafeChunk.after_hold": SafeChunk(
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        verdict_id=U64_MAX,
        judged_tick=1,
        first_tick=2,
        horizon=1,
        after=Acted(hold=Hold.NO_CLAIM, verdict_id=0, row=0),
        parts=(arm_delta(1),),
    ),
}

SAFETY = {
    "Lease": Lease(
        session=SESSION,
        epoch=EPOCH,
        lease_seq=88,
        config_hash=CONFIG_HASH,
        state=GateState.ARMED,
        state_tick=1008,
        grants=(
            Grant(
                source="runner",
                claim_id=CLAIM,
                until_tick=1010,
                decision=Decision.ROW,
                verdict_id=VERDICT,
            ),
            Grant(
                source="teleop",
                claim_id=CLAIM + 1,
                until_tick=1011,
                decision=Decision.HOLD,
                verdict_id=VERDICT + 1,
            ),
        ),
        stop_ids=(),
    ),
    "Lease.stopped": Lease(
        session=SESSION,
        epoch=EPOCH,
        lease_seq=89,
        config_hash=CONFIG_HASH,
        state=GateState.STOPPED,
        state_tick=1009,
        grants=(),
        stop_ids=(STOP, U64_MAX, 1),
    ),
    "Verdict": Verdict(
        verdict_id=VERDICT,
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        seq=43,
        outcome=Outcome.TRUNCATED,
        code=20,
        row=3,
        part="arm",
        axis="linear_norm",
        value=0.0900,
        limit=0.0867,
        margin=-0.0033,
        limit_source="parts.arm.modes.cartesian_delta.linear_limit",
        released_first=1009,
        released_last=1011,
        config_hash=CONFIG_HASH,
        latency_ns=12_345,
    ),
    "Verdict.released": Verdict(
        verdict_id=VERDICT,
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        seq=44,
        outcome=Outcome.RELEASED,
        code=0,
        row=-1,
        part="",
        axis="",
        value=0.0,
        limit=0.0,
        margin=0.0,
        limit_source="",
        released_first=1012,
        released_last=1019,
        config_hash=CONFIG_HASH,
        latency_ns=9_876,
    ),
    "Verdict.extremes": Verdict(
        verdict_id=U64_MAX,
        session=U64_MAX,
        epoch=U64_MAX,
        claim_id=U64_MAX,
        source="s" * 32,
        seq=U64_MAX,
        outcome=255,
        code=U32_MAX,
        row=-(2**31),
        part="p" * 31,
        axis="a" * 255,
        value=float("inf"),
        limit=float("-inf"),
        margin=float("nan"),
        limit_source="l" * 256,
        released_first=2**16 - 1,
        released_last=2**16,
        config_hash=NO_HASH,
        latency_ns=U64_MAX,
    ),
    "GateStatus": GateStatus(
        robot="panda_mobile",
        profile="sim",
        session=SESSION,
        epoch=EPOCH,
        state=GateState.STOPPED,
        cause="G008: chunk of runner holds a value that is not finite",
        fix="fairlead reset 0x66778899aabbccdd",
        latch_id=0,
        stop_ids=(STOP,),
        claims=(
            ClaimInfo(
                source="runner",
                skill="oracle-counter-to-cabinet",
                claim_id=CLAIM,
                parts=("arm", "gripper", "base", "composite"),
            ),
        ),
        counters=(("released", 120), ("truncated", 3), ("G008", 1)),
        state_tick=1010,
        lockstep_allowed=True,
        config_hash=CONFIG_HASH,
        robot_hash=ROBOT_HASH,
    ),
    "GateStatus.boot": GateStatus(
        robot="panda_mobile",
        profile="sim",
        session=0,
        epoch=0,
        state=GateState.BOOT,
        cause="",
        fix="",
        latch_id=U64_MAX,
        stop_ids=(),
        claims=(),
        counters=(),
        state_tick=0,
        lockstep_allowed=False,
        config_hash=CONFIG_HASH,
        robot_hash=ROBOT_HASH,
    ),
    "StopLevel": StopLevel(stop_id=STOP, by="operator", reason="someone walked in"),
    "StopLevel.empty": StopLevel(stop_id=U64_MAX, by="", reason=""),
    "Heartbeat": Heartbeat(claim_id=CLAIM),
    "Heartbeat.zero": Heartbeat(claim_id=0),
}

QUERY = {
    "Refusal": Refusal(who="safety", reason="claim: the gate is disarmed", fix="fairlead arm"),
    "Refusal.empty": Refusal(who="", reason="", fix=""),
    "Done": Done(text="disarmed"),
    "StatusQuery": StatusQuery(),
    "Arm": Arm(by="operator"),
    "ArmReply": ArmReply(epoch=EPOCH, session=SESSION),
    "Disarm": Disarm(by="operator"),
    "Reset": Reset(by="operator", id=STOP),
    "Claim": Claim(
        source="runner",
        skill="oracle-counter-to-cabinet",
        skill_hash=SKILL_HASH,
        robot_hash=ROBOT_HASH,
        period_ns=50_000_000,
        parts=("arm", "gripper", "base", "composite"),
        chunk_rate_hz=20.0,
        horizon_max=64,
        age_max_ticks=10,
        limits=(
            LimitOverride(
                part="arm", mode=ControlMode.CARTESIAN_DELTA, name="linear_limit", value=0.05
            ),
            LimitOverride(
                part="base", mode=ControlMode.JOINT_VELOCITY, name="step_limit", value=0.5
            ),
        ),
    ),
    "Claim.empty": Claim(
        source="runner",
        skill="",
        skill_hash=NO_HASH,
        robot_hash=NO_HASH,
        period_ns=0,
        parts=(),
        chunk_rate_hz=TINY,
        horizon_max=0,
        age_max_ticks=U32_MAX,
        limits=(),
    ),
    "ClaimReply": ClaimReply(claim_id=CLAIM, epoch=EPOCH, session=SESSION),
    "Release": Release(source="runner", claim_id=CLAIM),
    "ResetEpisode": ResetEpisode(seed=19),
    "ResetEpisodeReply": ResetEpisodeReply(tick=1020, episode_tick=1012, held_ticks=8),
    "Goal": Goal(
        skill="oracle-counter-to-cabinet",
        skill_hash=SKILL_HASH,
        prompt="put the can into the cabinet",
        deadline_ticks=600,
        stall_timeout_s=30.0,
    ),
    "Goal.defaults": Goal(
        skill="oracle-counter-to-cabinet",
        skill_hash=NO_HASH,
        prompt="",
        deadline_ticks=0,
        stall_timeout_s=HUGE,
    ),
    "GoalAccepted": GoalAccepted(goal_id=GOAL),
    "Cancel": Cancel(goal_id=GOAL, by="operator"),
    "GoalFeedback": GoalFeedback(
        source="runner",
        goal_id=GOAL,
        skill="oracle-counter-to-cabinet",
        phase="transport",
        tick=1021,
        queue_depth=5,
        inferences=37,
        starved=1,
        last_refusal="G022 row 4 base base_x 2.1 > 2.0",
        result=None,
    ),
    "GoalFeedback.result": GoalFeedback(
        source="runner",
        goal_id=GOAL,
        skill="oracle-counter-to-cabinet",
        phase="done",
        tick=1300,
        queue_depth=0,
        inferences=40,
        starved=0,
        last_refusal="",
        result=GoalResult(
            outcome="succeeded",
            decided_by="task",
            kind="",
            detail="object in the cabinet, released, at rest",
            first_tick=1001,
            last_tick=1299,
        ),
    ),
    "GoalFeedback.failed": GoalFeedback(
        source="runner",
        goal_id=GOAL,
        skill="oracle-counter-to-cabinet",
        phase="approach",
        tick=1300,
        queue_depth=0,
        inferences=0,
        starved=U64_MAX,
        last_refusal="",
        result=GoalResult(
            outcome="failed",
            decided_by="runner",
            kind="layout_missing_frame",
            detail="frame object not seen from odom",
            first_tick=0,
            last_tick=0,
        ),
    ),
}

MESSAGES: dict[str, Message] = {**STATE, **ACTION, **SAFETY, **QUERY}
