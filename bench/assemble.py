"""What a tick costs the state assembler: from the bytes of the joints to the bytes of the layout.

    .venv/bin/python -m bench.assemble [--skill ID] [--ticks N] [--json] [--write]

Medians of the service's own core, without its bus: decoding, forward kinematics, the vector and its
message, tick after tick of messages that were made beforehand. By the monotonic clock: to read that
of processor time takes as long as a tenth of it all. Apart: the HAL's transforms, which come before
the joints, and the message of the links' transforms, which goes out after the layout.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time

import numpy as np

from bench.page import Write, write_table
from fairlead.frames import MAP, ODOM
from fairlead.messages import (
    HELD,
    JointState,
    Transform,
    TransformBatch,
    decode,
    encode,
    pack_floats,
)
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.manifest import load_skill
from fairlead_state_assembler.core import AssemblerCore
from fairlead_state_assembler.publishers import Publishers
from fairlead_state_assembler.skill_view import SkillView

AIM_US, WARM_UP = 30.0, 100


def messages(robot: RobotManifest, frames: dict[str, str], tick: int) -> tuple[bytes, bytes]:
    """The HAL's transforms (parents by child) and joints of a tick."""
    rng = np.random.default_rng(tick)
    n = len(robot.measured_joint_names)
    transforms = tuple(
        Transform(
            parent=parent,
            child=child,
            translation=pack_floats(rng.uniform(-1.0, 1.0, 3)),
            rotation_xyzw=pack_floats([0.0, 0.0, 0.0, 1.0]),
        )
        for child, parent in frames.items()
    )
    batch = TransformBatch(session=1, tick=tick, is_static=False, transforms=transforms)
    state = JointState(
        session=1, tick=tick, episode_tick=1, stamp_ns=0,
        positions=pack_floats(rng.uniform(-0.5, 0.5, n)), velocities=pack_floats(np.zeros(n)),
        efforts=pack_floats(np.zeros(n)), acted=(HELD,) * len(robot.parts),
        robot_hash=robot.robot_hash,
    )  # fmt: skip
    return encode(batch), encode(state)


def measure(skill_id: str, ticks: int) -> dict[str, float]:
    """Medians of a tick [us]: ``joints_us`` to the layout, ``transforms_us``, ``links_us``."""
    skill = load_skill(skill_id)
    robot = load_robot(skill.embodiments[0])
    core = AssemblerCore(robot, Publishers())
    core.want(SkillView(skill.id))
    bound = skill.state_contract.bindings
    objects = [one for one in (bound.object_frame, bound.goal_frame) if one] if bound else []
    frames = {robot.base_frame: ODOM, ODOM: MAP} | dict.fromkeys(objects, MAP)
    came = [messages(robot, frames, tick) for tick in range(1, ticks + WARM_UP + 1)]
    joints_us, transforms_us, links_us = [], [], []
    for tick, (batch, state) in enumerate(came, 1):
        began_ns = time.perf_counter_ns()
        core.on_transforms(decode(TransformBatch, batch), "hal")
        between_ns = time.perf_counter_ns()
        outputs = core.on_joints(decode(JointState, state))
        ended_ns = time.perf_counter_ns()
        assert all(one.payload for one in outputs)
        links_us.append((time.perf_counter_ns() - ended_ns) / 1e3)
        if not any(one.skill == skill.id for one in outputs):
            raise SystemExit(f"bench.assemble: no layout of {skill.id} at tick {tick}")
        transforms_us.append((between_ns - began_ns) / 1e3)
        joints_us.append((ended_ns - between_ns) / 1e3)
    return {
        "joints_us": statistics.median(joints_us[WARM_UP:]),
        "transforms_us": statistics.median(transforms_us[WARM_UP:]),
        "links_us": statistics.median(links_us[WARM_UP:]),
    }


def main() -> int:
    """Measure and print; 1 if the aim is missed."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.assemble",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--skill", default="oracle-counter-to-cabinet")
    parser.add_argument("--ticks", type=int, default=5000)
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    parser.add_argument("--write", action=Write, help="put the table into docs/speed.md")
    args = parser.parse_args()
    found = measure(args.skill, args.ticks)
    text = (
        "| skill | joints to layout, us | transforms before, us | links after, us | aim |\n"
        "|---|---|---|---|---|\n"
        f"| {args.skill} | {found['joints_us']:.0f} | {found['transforms_us']:.0f} "
        f"| {found['links_us']:.0f} "
        f"| <= {AIM_US:.0f} |"
    )
    print(json.dumps(found | {"skill": args.skill}) if args.json else text)
    if args.write:
        write_table("assemble", text)
    return 0 if found["joints_us"] <= AIM_US else 1


if __name__ == "__main__":
    raise SystemExit(main())
