"""A program of one's own: it has a robot run a skill, and looks on."""

import argparse
import asyncio
import sys

from fairlead import connect
from fairlead.errors import FairleadError
from fairlead.messages import floats


async def main(deployment: str, skill: str, prompt: str) -> None:
    async with connect(deployment, by="my program") as robot:
        await robot.arm()
        goal = await robot.run(skill, prompt=prompt, deadline_ticks=600)
        async for progress in goal:
            print(progress.line())
        result = await goal.result()
        print(f"{result.outcome}: {result.detail}")
        async for state in robot.joint_states():
            print(f"at tick {state.tick}: {floats(state.positions)}")
            break
        await robot.disarm()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("deployment", "skill", "prompt"):
        parser.add_argument(name)
    try:
        asyncio.run(main(**vars(parser.parse_args())))
    except FairleadError as error:
        sys.exit(f"ERROR {error}")
