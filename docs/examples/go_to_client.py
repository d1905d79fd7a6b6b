"""A planner of one's own: it claims the base and drives it to a pose through the gate."""

import math
import sys
from pathlib import Path

import numpy as np

from fairlead import ControlMode, RobotClient, claim_parts, load_deployment, load_robot
from fairlead.messages import ActionPart, TransformBatch, decode, floats, pack_floats

ROWS = 8  # of 50 ms: so long the base goes on if this program says nothing new
FASTEST = 0.3, 0.6  # m/s ahead, rad/s to the left


def rates(goal, pose):
    """Turn towards the goal, drive straight, turn to its yaw; None once it is there."""
    (x, y, yaw), (goal_x, goal_y, goal_yaw) = pose, goal
    away_m = math.hypot(goal_x - x, goal_y - y)
    bearing = math.remainder(math.atan2(goal_y - y, goal_x - x) - yaw, math.tau)
    turn = math.remainder(goal_yaw - yaw, math.tau)
    if away_m > 0.03:
        return (2 * away_m if abs(bearing) < 0.1 else 0.0), 2 * bearing
    return (0.0, 2 * turn) if abs(turn) > 0.03 else None


def main(file, *goal):
    deployment = load_deployment(Path(file))
    robot, poses = load_robot(deployment.robot), {}

    def on_transforms(sample):
        batch = decode(TransformBatch, sample.payload)
        for one in batch.transforms:
            if (one.parent, one.child) == ("odom", "base_link"):
                (x, y, _), (_, _, z, w) = floats(one.translation), floats(one.rotation_xyzw)
                poses[batch.tick] = float(x), float(y), 2 * math.atan2(z, w)

    with RobotClient(deployment, by="planner") as client:
        client.bus.subscribe(client.keys.tf("hal"), on_transforms)
        with claim_parts(client, "planner", robot, ["base"], task="go there") as claim:
            while True:
                tick = claim.next_state().tick  # the transforms of a tick come before its joints
                if tick not in poses:
                    continue
                told = rates([float(number) for number in goal], poses[tick])
                if told is None:
                    break
                ahead, left = np.clip(told, np.negative(FASTEST), FASTEST)
                rows = pack_floats(np.tile([ahead, 0, 0, 0, 0, left], (ROWS, 1)))
                base = ActionPart(
                    part=robot.part_names.index("base"),
                    mode=ControlMode.BODY_TWIST,
                    frame_id="base_link",
                    values=rows,
                    active=(),
                )
                claim.send(tick, [base])
    print(f"there: {poses[tick]}")


if __name__ == "__main__":
    main(*sys.argv[1:])
