"""Which deployment files of this installation switch on the cameras that a skill needs."""

from __future__ import annotations

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.shipped_deployments import shipped_deployments
from fairlead.skill.manifest import SkillManifest


def camera_deployments(skill: SkillManifest, robot: str) -> list[str]:
    """Names of one robot's deployments in ``compose/`` with a skill's cameras, in its sizes."""
    needed = {(image.camera, image.width, image.height) for image in skill.images.values()}
    return [
        name for name, deployment in shipped_deployments(robot) if needed <= _rendered(deployment)
    ]


def _rendered(deployment: Deployment) -> set[tuple[object, object, object]]:
    """Name, width and height [px] of each camera the HAL is told to render."""
    cameras = deployment.services[deployment.hal].options.get("cameras")
    listed = cameras if isinstance(cameras, list) else []
    blocks = [one for one in listed if isinstance(one, dict)]
    return {(one.get("name"), one.get("width"), one.get("height")) for one in blocks}
