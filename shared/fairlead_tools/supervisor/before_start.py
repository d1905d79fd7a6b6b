"""What is refused and what is warned of before a process of a deployment is started."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

from fairlead.deploy.access_warnings import access_warnings
from fairlead.deploy.deployment import Deployment
from fairlead.deploy.hosts import ROUTER
from fairlead.deploy.service_options import check_options
from fairlead.deploy.shared_router import router_endpoints
from fairlead.errors import ConfigError
from fairlead.hal.serve import checked_hal
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import state_problems
from fairlead.skill.camera_check import camera_problems, rendered
from fairlead.skill.manifest import SkillManifest, load_skill, skill_ids
from fairlead_tools.supervisor.command_line import check_gate_file, service_command

Check = Callable[[], Iterable[str]]
"""Returns warnings; raises a `FairleadError` for what cannot work."""


def checks(file: Path, deployment: Deployment, processes: Iterable[str]) -> Iterator[Check]:
    """All of them, for the processes that one host starts."""
    yield partial(warning_lines, deployment)
    for name in processes:
        yield partial(_can_prove_its_name, deployment, name)
        yield partial(_can_be_executed, file, deployment, name)
        yield partial(_options_fit, deployment, name)
        if name in deployment.runners:
            yield partial(dropped_skills, deployment, name)


def warning_lines(deployment: Deployment) -> list[str]:
    """Of access that is open, and of certificates."""
    return [f"WARNING {text}" for text in access_warnings(deployment)]


def _can_prove_its_name(deployment: Deployment, name: str) -> Iterable[str]:
    _ = router_endpoints([deployment]) if name == ROUTER else deployment.endpoints(name)
    return ()


def _can_be_executed(file: Path, deployment: Deployment, name: str) -> Iterable[str]:
    if name == deployment.only("safety"):
        check_gate_file(deployment)
    else:
        service_command(file, deployment, name, Path())
    return ()


def _options_fit(deployment: Deployment, name: str) -> Iterable[str]:
    """As the service itself checks them; those of a program that is named by ``command`` it alone.

    Imported late: what starts nothing here need not load the services.
    """
    spec = deployment.services.get(name)
    if spec is not None and spec.run == "state_assembler":
        from fairlead_state_assembler import AssemblerOptions

        check_options(deployment, name, AssemblerOptions)
    elif spec is not None and spec.run == "skill_runner":
        from fairlead_skill_runner import RunnerOptions

        check_options(deployment, name, RunnerOptions)
    elif name == deployment.hal and spec is not None and spec.run:
        checked_hal(deployment, name)
    return ()


def _missing_pictures(deployment: Deployment, skill: SkillManifest) -> list[str]:
    """What a skill wants to see and no camera of the HAL shows, where its options list them."""
    hal = deployment.hal
    try:
        driver, _ = checked_hal(deployment, hal)
    except ConfigError:  # said on its own host, which may have more packages
        return []
    if "cameras" not in driver.options.model_fields:
        return []
    period_ns = load_robot(deployment.robot).tick_period_ns
    return [
        f"{problem}; options.cameras of {hal} in the deployment file switches cameras on"
        for problem in camera_problems(skill, rendered(deployment), period_ns)
    ]


def dropped_skills(deployment: Deployment, runner: str) -> Iterator[str]:
    """A line for each skill that a runner offers whose state vector nothing can fill.

    Raises:
        ConfigError: if the deployment asks by its name for such a skill, or one that does not load.
    """
    robot = load_robot(deployment.robot)
    listed = deployment.services[runner].options.get("skills")
    wanted = listed if isinstance(listed, list) else None
    for name in skill_ids() if wanted is None else wanted:
        try:
            skill = load_skill(name)
        except ConfigError:
            if wanted is not None:
                raise
            continue  # the runner leaves it out, and says what is wrong with the file
        if wanted is not None:
            for problem in _missing_pictures(deployment, skill):
                yield f"{runner}: skill {name}: {problem}"
        problems = state_problems(skill.state_contract, robot)
        if not problems or (wanted is None and robot.id not in skill.embodiments):
            continue
        reasons = "".join(f"\n  {problem}" for problem in problems)
        if wanted is not None:
            raise ConfigError(f"skill {name} cannot run on robot {robot.id}:{reasons}")
        yield f"{runner}: skill {name} is dropped, it cannot run on robot {robot.id}:{reasons}"
