"""Which deployment files of this installation switch on the cameras that a skill needs."""

from __future__ import annotations

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError
from fairlead.paths import repo_root
from fairlead.skill.manifest import SkillManifest


def camera_deployments(skill: SkillManifest, robot: str) -> list[str]:
    """Names of the deployments in ``compose/`` of one robot with a skill's cameras, in its sizes.

    A file that does not load is left out: `fairlead up` says what is wrong with it.
    """
    needed = {(image.camera, image.width, image.height) for image in skill.images.values()}
    found = []
    for path in sorted((repo_root() / "compose").glob("*.yaml")):
        try:
            deployment = load_deployment(path)
            rendered = _rendered(deployment)
        except ConfigError:
            continue
        if deployment.robot == robot and needed <= rendered:
            found.append(path.stem)
    return found


def _rendered(deployment: Deployment) -> set[tuple[object, object, object]]:
    """Name, width and height [px] of each camera the HAL is told to render."""
    cameras = deployment.services[deployment.hal].options.get("cameras")
    listed = cameras if isinstance(cameras, list) else []
    blocks = [one for one in listed if isinstance(one, dict)]
    return {(one.get("name"), one.get("width"), one.get("height")) for one in blocks}
