"""A service's ``options`` in a deployment file, which the service itself defines."""

from __future__ import annotations

from typing import TypeVar

from pydantic import BaseModel

from fairlead.checked_model import checked_model
from fairlead.deploy.deployment import Deployment

Options = TypeVar("Options", bound=BaseModel)


def check_options(deployment: Deployment, service: str, model: type[Options]) -> Options:
    """A service's ``options`` as its model.

    Raises:
        ConfigError: naming the service and every option that does not fit, with its line.
    """
    return checked_model(
        f"service {service}: options",
        model,
        deployment.services[service].options,
        lambda place: deployment.where("services", service, "options", *place),
    )
