"""``fairlead bridge``: a running robot in the terms of another system."""

from __future__ import annotations

import threading
from typing import Annotated

import typer

from fairlead.checked_model import checked_model
from fairlead.operate.client import RobotClient
from fairlead.ros2.link import DEFAULT_ROUTER, Ros2Link
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.options import DeploymentOption, choose_deployment, example, make_group

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


group = make_group("bridge", "Show a running robot to another system.", {"ros2": ros2_command})
