"""``python -m fairlead_skill_runner --deployment FILE --service NAME --state-dir DIR``."""

from __future__ import annotations

from fairlead.deploy.service_options import check_options
from fairlead.robot.manifest import load_robot
from fairlead.service import ServiceContext, announce_ready, run_service
from fairlead_skill_runner.offered_skills import OfferedSkills
from fairlead_skill_runner.options import RunnerOptions
from fairlead_skill_runner.service import SkillRunner


async def serve(context: ServiceContext) -> None:
    """Offer the configured skills until asked to stop."""
    options = check_options(context.deployment, context.name, RunnerOptions)
    options.check_profile(context.name, context.deployment.profile)
    robot = load_robot(context.deployment.robot)
    skills = OfferedSkills(context.name, options, robot, context.deployment.profile)
    trace_file = context.state_dir / "trace.jsonl" if options.trace else None
    runner = SkillRunner(context, skills, trace_file)
    try:
        announce_ready(context)
        await context.stopping.wait()
    finally:
        await runner.close()


if __name__ == "__main__":
    raise SystemExit(run_service("fairlead-skill-runner", serve))
