"""``python -m fairlead.hal.serve``: the process of a HAL that an installed package brings."""

from __future__ import annotations

import logging
import sys
from typing import Any

from fairlead.deploy.service_options import check_options
from fairlead.errors import ConfigError, expected
from fairlead.hal.process import HalDriver, run_hal
from fairlead.plugins import HALS
from fairlead.robot.manifest import load_robot
from fairlead.service import ServiceContext, run_service


async def body(context: ServiceContext) -> None:
    """Load the HAL that the deployment file names and run it until asked to stop.

    Raises:
        ConfigError: no installed package has it, it does not load, or options or pacing do not fit.
    """
    name = context.deployment.services[context.name].run
    driver = hal_driver(name, context.deployment.who(context.name, "run"))
    if driver.realtime_only and context.deployment.pacing != "realtime":
        who = f"service {context.name}: {name}: pacing"
        raise ConfigError(expected(who, "realtime", context.deployment.pacing))
    options = check_options(context.deployment, context.name, driver.options)
    profile = context.deployment.profile
    if (
        driver.realtime_only
        and load_robot(context.deployment.robot).profile(profile).lockstep_allowed
    ):
        logging.getLogger(context.name).warning(
            "profile %s has the limits of a simulator, and %s may move a real robot", profile, name
        )
    await run_hal(context, lambda robot: driver.equip(robot, profile, options), what=name)


def hal_driver(name: str, who: str) -> HalDriver[Any]:
    """The HAL of a name, imported from the package that registers it.

    Raises:
        ConfigError: nobody registers it, with the names there are; or what is behind it is no
            HAL, naming the package.
    """
    plugin = HALS.find(name, who)
    found = plugin.load()
    if not isinstance(found, HalDriver):
        raise plugin.refuse("a fairlead.hal.process.HalDriver", found)
    return found


if __name__ == "__main__":
    sys.exit(run_service("fairlead-hal", body))
