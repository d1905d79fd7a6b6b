"""Whether what an RLDX or GR00T server wants and gives is what a skill sends and takes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policies.remote.modality_config import Modality


def modality_problems(
    modalities: Mapping[str, Modality],
    skill: SkillManifest,
    states: Iterable[str],
    actions: Iterable[str],
    language_key: str,
) -> list[str]:
    """Every difference; of what the server does not tell, none.

    Args:
        states, actions: names on the wire, from the policy's options.
        language_key: of the prompt.
    """
    problems = []
    for kind, names, where in (
        ("video", skill.images, "images"),
        ("state", states, "policy.options.state"),
        ("action", actions, "policy.options.actions"),
    ):
        told = modalities.get(kind)
        if told is not None:
            problems += _name_problems(kind, told.modality_keys, list(names), where)
    problems += _time_problems(modalities, skill)
    language = modalities.get("language")
    if language is not None and language_key not in language.modality_keys:
        wanted = ", ".join(language.modality_keys)
        problems.append(f"policy.options.language_key: it wants {wanted}, got {language_key}")
    return problems


def _name_problems(kind: str, theirs: Sequence[str], ours: Sequence[str], where: str) -> list[str]:
    if set(theirs) == set(ours):
        return []
    verb = "gives" if kind == "action" else "wants"
    return [f"{where}: it {verb} {', '.join(theirs)}, the skill has {', '.join(ours)}"]


def _time_problems(modalities: Mapping[str, Modality], skill: SkillManifest) -> list[str]:
    problems = []
    video, state = modalities.get("video"), modalities.get("state")
    if video is not None:
        problems += [
            f"images: it wants frames at deltas {list(video.delta_indices)}, {name} has "
            f"{list(image.deltas)}"
            for name, image in skill.images.items()
            if image.deltas != video.delta_indices
        ]
    if state is not None and state.delta_indices != (0,):
        problems.append(
            f"state_contract: it wants states at deltas {list(state.delta_indices)}, a skill "
            "sends the newest"
        )
    action = modalities.get("action")
    if action is not None and len(action.delta_indices) > skill.horizon:
        problems.append(
            f"horizon: it gives {len(action.delta_indices)} rows, the skill takes {skill.horizon}"
        )
    if action is not None and action.delta_indices != tuple(range(len(action.delta_indices))):
        problems.append(
            f"rate_hz: it gives rows at deltas {list(action.delta_indices)}, the skill takes one "
            "for each period, from 0 on"
        )
    return problems
