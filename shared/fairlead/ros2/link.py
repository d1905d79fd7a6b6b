"""Where a ROS 2 system is: its router, its domain, its release."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from fairlead.errors import expected
from fairlead.ros2.grammar import TOPIC_NAME

Distro = Literal["humble", "jazzy", "kilted", "lyrical"]
DEFAULT_ROUTER = "tcp/127.0.0.1:7447"


def checked_topic(name: str) -> str:
    """A topic's or namespace's full name; else a `ValueError`."""
    if not TOPIC_NAME.fullmatch(name):
        raise ValueError(expected("name", "a full ROS name such as /arm/joint_states", repr(name)))
    return name


def _router(endpoint: str) -> str:
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.rpartition(":")
    if protocol != "tcp" or not host or not port.isdecimal() or not 0 < int(port) < 2**16:
        what = "an endpoint such as tcp/127.0.0.1:7447"
        raise ValueError(expected("router", what, repr(endpoint)))
    return endpoint


Topic = Annotated[str, AfterValidator(checked_topic)]


class Ros2Link(BaseModel):
    """How to reach a ROS 2 system that runs on rmw_zenoh.

    router: the endpoint of its Zenoh router (``rmw_zenohd``).
    domain: its ``ROS_DOMAIN_ID``.
    distro: its release; keys have type hashes from Jazzy on.
    namespace: of our node; "" for none.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    router: Annotated[str, AfterValidator(_router)] = DEFAULT_ROUTER
    domain: int = Field(default=0, ge=0, le=232)
    distro: Distro = "jazzy"
    namespace: Annotated[str, AfterValidator(lambda name: name and checked_topic(name))] = ""
