"""A planner of one's own: it claims the base and drives it to a pose through the gate."""

import argparse
import asyncio
import math
import sys

import numpy as np

from fairlead import ControlMode, connect
from fairlead.errors import FairleadError

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


async def main(deployment, *goal):
    async with (
        connect(deployment, by="planner") as robot,
        robot.claim(["base"], source="planner", task="go there") as claim,
    ):
        tick = await claim.next_tick()
        while told := rates(goal, tick.planar_pose("odom", "base_link")):
            ahead, left = np.clip(told, np.negative(FASTEST), FASTEST)
            rows = np.tile([ahead, 0, 0, 0, 0, left], (ROWS, 1))
            await claim.send(tick.number, claim.rows("base", ControlMode.BODY_TWIST, rows))
            tick = await claim.next_tick()
    print(f"there: {tick.planar_pose('odom', 'base_link')}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("deployment")
    for name in ("x_m", "y_m", "yaw_rad"):
        parser.add_argument(name, type=float)
    try:
        asyncio.run(main(*vars(parser.parse_args()).values()))
    except FairleadError as error:
        sys.exit(f"ERROR {error}")
