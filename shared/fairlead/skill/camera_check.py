"""Whether a robot's cameras give the pictures that a skill's policy wants, and where some do."""

from __future__ import annotations

from collections.abc import Iterable
from math import gcd

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.shipped_deployments import shipped_deployments
from fairlead.messages import HalCamera, HalStatus
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import SkillManifest


def camera_problems(
    skill: SkillManifest, cameras: Iterable[HalCamera], period_ns: int
) -> list[str]:
    """Every picture that none of the cameras gives, in its size and as often as it is wanted."""
    known = {camera.name: camera for camera in cameras}
    problems = []
    for name, image in skill.images.items():
        camera = known.get(image.camera)
        if camera is None:
            problems.append(
                f"images: {name} needs camera {image.camera!r} "
                f"(valid: {', '.join(known) or 'none'})"
            )
            continue
        if (camera.width, camera.height) != (image.width, image.height):
            problems.append(
                f"images: {name} expects {image.width} x {image.height} pixels, camera "
                f"{image.camera} gives {camera.width} x {camera.height}"
            )
        spacing = gcd(*image.deltas) * (skill.control_periods(period_ns) or 1)
        if spacing % camera.period_ticks != 0:
            problems.append(
                f"images: {name} wants frames at deltas {', '.join(map(str, image.deltas))}, so "
                f"one every {spacing} ticks or a whole fraction of that; camera {camera.name} "
                f"gives one every {camera.period_ticks} (its period_ticks)"
            )
    return problems


def way_to_cameras(skill: SkillManifest, robot: RobotManifest, hal: HalStatus) -> str:
    """What to do about a HAL whose cameras do not give what a skill wants."""
    if "cameras off" in hal.detail:  # they were asked for, and nothing renders them
        return f"fairlead logs, which says why; the HAL: {hal.detail}"
    for name, deployment in shipped_deployments(robot.id):
        if not camera_problems(skill, rendered(deployment), robot.tick_period_ns):
            return f"fairlead down, then fairlead up {name}, which has these cameras"
    return "options.cameras of the HAL in the deployment file switches cameras on"


def rendered(deployment: Deployment) -> list[HalCamera]:
    """The cameras that the HAL is told to render; none of a HAL that calls them otherwise."""
    cameras = deployment.services[deployment.hal].options.get("cameras")
    listed = cameras if isinstance(cameras, list) else []
    names = HalCamera.__struct_fields__
    blocks = [one for one in listed if isinstance(one, dict) and set(names) <= one.keys()]
    return [HalCamera(**{name: one[name] for name in names}) for one in blocks]
