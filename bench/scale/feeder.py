"""Run beside one robot: claims its arm and sends chunks that sway it, until it is ended.

``python -m bench.scale.feeder DEPLOYMENT``. Each chunk has 16 rows and comes 8 ticks after the one
before, as of a policy that is asked when half of its rows are used up. When the claim is lost, on a
machine that is full, it begins anew.
"""

from __future__ import annotations

import asyncio
import math
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from fairlead import ControlMode, PartClaim, Robot, RobotManifest, connect
from fairlead.errors import ChunkRefusedError, FairleadError
from fairlead.messages import GateState

HORIZON, EXECUTE = 16, 8
PART, SWAY_RAD, TURN_TICKS = "arm", 0.02, 100
"""Twice the sway is less than a step may be: wherever it held, it can go on."""
PAUSE_S = 1.0


def rows(manifest: RobotManifest, tick: int) -> Iterator[list[float]]:
    """Positions [rad] for a chunk's ticks: the first joint sways about where it starts."""
    assert manifest.home is not None
    first, *others = manifest.part(PART).joints
    home = manifest.home.positions
    for ahead in range(HORIZON):
        sway = SWAY_RAD * math.sin(math.tau * (tick + ahead) / TURN_TICKS)
        yield [home[first] + sway, *(home[joint] for joint in others)]


async def feed(manifest: RobotManifest, claim: PartClaim) -> None:
    """Chunk after chunk, until the claim is lost."""
    due = 0
    while True:
        tick = (await claim.next_tick()).number
        if tick >= due:
            part = claim.rows(PART, ControlMode.JOINT_POSITION, list(rows(manifest, tick)))
            try:
                await claim.send(tick, part)
            except ChunkRefusedError as error:  # it came too late, say
                print(error, flush=True)
                continue
            if due == 0:
                print("moves", flush=True)
            due = tick + EXECUTE


async def make_ready(robot: Robot) -> None:
    """Armed, whatever was before."""
    gate = await robot.wait_gate_follows()
    for one in (gate.latch_id, *gate.stop_ids):
        if one:
            await robot.reset(one)
    if gate.state != GateState.ARMED:
        await robot.arm()


async def main(file: Path) -> None:
    """Feed the robot of a deployment until the process is ended."""
    while True:
        try:
            async with connect(file, by="bench.scale") as robot:
                await make_ready(robot)
                async with robot.claim([PART], source="feeder") as claim:
                    await feed(robot.manifest, claim)
        except FairleadError as error:
            print(f"{time.monotonic():.1f} {error}", flush=True)
            await asyncio.sleep(PAUSE_S)


if __name__ == "__main__":
    asyncio.run(main(Path(sys.argv[1])))
