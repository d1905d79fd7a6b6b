"""``python -m fairlead.hal.serve``: the process of a HAL that an installed package brings."""

from __future__ import annotations

import logging
import sys
from typing import Any

from pydantic import BaseModel

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.service_options import check_options
from fairlead.errors import ConfigError, expected
from fairlead.hal.process import HalDriver, run_hal
from fairlead.plugins import HALS
from fairlead.robot.manifest import load_robot
from fairlead.service import ServiceContext, run_service


async def body(context: ServiceContext) -> None:
    """Load the HAL that the deployment file names and run it until asked to stop.

    Raises:
        ConfigError: as `checked_hal`.
    """
    name = context.deployment.services[context.name].run
    driver, options = checked_hal(context.deployment, context.name)
    profile = context.deployment.profile
    if (
        driver.realtime_only
        and load_robot(context.deployment.robot).profile(profile).lockstep_allowed
    ):
        logging.getLogger(context.name).warning(
            "profile %s has the limits of a simulator, and %s may move a real robot", profile, name
        )
    await run_hal(context, lambda robot: driver.equip(robot, profile, options), what=name)


def checked_hal(deployment: Deployment, service: str) -> tuple[HalDriver[Any], BaseModel]:
    """The HAL that a service of a deployment file names, and its options.

    Raises:
        ConfigError: no installed package has it, it does not load, or options or pacing do not fit.
    """
    name = deployment.services[service].run
    driver = hal_driver(name, deployment.who(service, "run"))
    if driver.realtime_only and deployment.pacing != "realtime":
        raise ConfigError(
            expected(f"service {service}: {name}: pacing", "realtime", deployment.pacing)
        )
    return driver, check_options(deployment, service, driver.options)


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
