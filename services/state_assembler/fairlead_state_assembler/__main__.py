"""``python -m fairlead_state_assembler``: the state assembler's process."""

from __future__ import annotations

import sys

from fairlead.deploy.service_options import check_options
from fairlead.robot.manifest import load_robot
from fairlead.service import ServiceContext, announce_ready, run_service
from fairlead_state_assembler.core import AssemblerCore
from fairlead_state_assembler.options import AssemblerOptions
from fairlead_state_assembler.publishers import Publishers
from fairlead_state_assembler.transport import AssemblerTransport


async def assemble(context: ServiceContext) -> None:
    """Assemble until the process is asked to stop."""
    deployment = context.deployment
    options = check_options(deployment, context.name, AssemblerOptions)
    robot = load_robot(deployment.robot)
    publishers = Publishers(deployment.hal, context.name, deployment.localiser)
    core = AssemblerCore(robot, publishers, options.max_age_ticks)
    transport = AssemblerTransport(context.bus, deployment.keys, context.name, core)
    context.tasks.create_task(transport.follow_wants(), name="wants")
    announce_ready(context)
    await context.stopping.wait()
    transport.close()


if __name__ == "__main__":
    sys.exit(run_service("fairlead-state-assembler", assemble))
