"""``fairlead bridge`` and ``serve-policy``: a running robot, and a policy, for other systems."""

from __future__ import annotations

import asyncio
import os
import threading
from typing import Annotated

import typer

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, expected
from fairlead.operate.client import RobotClient
from fairlead.ros2.link import DEFAULT_ROUTER, Ros2Link
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.options import (
    DeploymentOption,
    SkillArgument,
    choose_deployment,
    example,
    make_group,
)

NODE = "fairlead_bridge"


@example("fairlead bridge ros2 --router tcp/127.0.0.1:7447 --prefix /panda")
def ros2_command(
    deployment: DeploymentOption = None,
    router: Annotated[
        str, typer.Option(help="where the ROS 2 system's router, rmw_zenohd, listens")
    ] = DEFAULT_ROUTER,
    domain: Annotated[int, typer.Option(help="its ROS_DOMAIN_ID")] = 0,
    distro: Annotated[str, typer.Option(help="its release")] = "jazzy",
    prefix: Annotated[str, typer.Option(help="before every topic, such as /panda")] = "",
) -> None:
    """Publish a running robot's joints, transforms, pictures and verdicts in ROS 2 until Ctrl-C.

    Topics: /joint_states, /tf, /tf_static, /camera/NAME/image_raw, /diagnostics.
    """
    from fairlead.ros2.node import RosNode  # needs the extra `ros2`
    from fairlead_tools.bridge.ros2_bridge import Ros2Bridge

    given = {"router": router, "domain": domain, "distro": distro, "namespace": prefix}
    link = checked_model("fairlead bridge ros2", Ros2Link, given)
    with RobotClient(choose_deployment(deployment)) as client:
        client.wait_anyone()
        hal = client.hal_status()
        node = RosNode(link, NODE)
        try:
            joints = (*hal.joints, *hal.passive_joints)
            Ros2Bridge(client.bus, client.keys, joints, node, link.namespace)
            echo(f"publishes {hal.robot} as node {link.namespace}/{NODE} in domain {domain}")
            threading.Event().wait()
        finally:
            node.close()


bridge_group = make_group(
    "bridge", "Show a running robot to another system.", {"ros2": ros2_command}
)


@example("fairlead serve-policy oracle-counter-to-cabinet --port 8000")
def serve_policy_command(
    skill: SkillArgument,
    host: Annotated[str, typer.Option(help="address to listen on")] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="0: any that is free; it is printed")
    ] = 8000,
    state_key: Annotated[str, typer.Option(help="name of the state")] = "observation/state",
    prompt_key: Annotated[str, typer.Option(help="name of the prompt")] = "prompt",
    api_key_env: Annotated[
        str, typer.Option(metavar="NAME", help="environment variable with the key clients need")
    ] = "",
) -> None:
    """Serve SKILL's policy to one client at a time, by the openpi websocket protocol.

    No robot and no gate: the client decides what becomes of the rows. Ends with Ctrl-C.
    """
    from fairlead_tools.cli.skill import installed_skill

    key = os.environ.get(api_key_env, "") if api_key_env else None
    if key is not None and (not key or not key.isprintable()):
        who = "serve-policy: --api-key-env"
        raise ConfigError(expected(who, f"one line in {api_key_env}", "nothing or more"))
    keys = (state_key, prompt_key)
    asyncio.run(_serve(load_skill(installed_skill(skill)), host, port, keys, key))


async def _serve(
    skill: SkillManifest, host: str, port: int, keys: tuple[str, str], api_key: str | None
) -> None:
    from fairlead_skill_runner import PolicyServer
    from fairlead_tools.parity.local_episode import make_policy

    policy = make_policy("serve-policy", skill)
    server = PolicyServer(skill, policy, keys, api_key, lambda line: echo(line))
    try:
        opened = await server.listen(host, port)
    except OSError as error:
        where = f"--host {host} --port {port}"
        raise ConfigError(
            f"serve-policy: {where}: cannot listen: {error.strerror or error}"
        ) from None
    async with opened as listening:
        where = next(iter(listening.sockets)).getsockname()
        echo(f"{skill.id}: listening on ws://{where[0]}:{where[1]}")
        await asyncio.Event().wait()
