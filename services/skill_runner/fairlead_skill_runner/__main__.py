"""``python -m fairlead_skill_runner --deployment FILE --service NAME --state-dir DIR``."""

from __future__ import annotations

import logging

from fairlead.robot.manifest import load_robot
from fairlead.service import ServiceContext, announce_ready, run_service
from fairlead_skill_runner.options import check_runner_options
from fairlead_skill_runner.service import SkillRunner


def serve(context: ServiceContext) -> None:
    """Offer the configured skills until asked to stop."""
    options = check_runner_options(context.name, context.options)
    skills = options.manifests(context.deployment.robot)
    if not skills:
        logging.getLogger(context.name).warning(
            "no skill is made for %s; make one: fairlead skill new, fairlead skill install, "
            "fairlead restart %s",
            context.deployment.robot,
            context.name,
        )
    runner = SkillRunner(
        context.bus,
        context.deployment.keys,
        context.name,
        load_robot(context.deployment.robot),
        context.deployment.profile,
        skills,
        options.replaced_policies(skills),
        context.state_dir / "trace.jsonl" if options.trace else None,
    )
    try:
        announce_ready(context)
        context.stopping.wait()
    finally:
        runner.close()


if __name__ == "__main__":
    raise SystemExit(run_service("fairlead-skill-runner", serve))
