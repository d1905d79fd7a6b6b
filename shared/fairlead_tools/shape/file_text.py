"""``capsules.yaml`` as text: one capsule a line, and every pair with the names of its links."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence

from fairlead.robot.capsules import Capsule
from fairlead_tools.shape.capsule_pairs import CapsulePair


def file_text(
    robot: str, source: str, capsules: Sequence[Capsule], pairs: Sequence[CapsulePair]
) -> str:
    """The file's text, which ends in a newline."""
    return "\n".join(
        [
            f"# Shape of {robot}, made by the command in `source`. After a change of it run",
            f"# `fairlead robot compile {robot}`. Lengths in m, in each link's own frame.",
            f"source: {json.dumps(source)}",
            "capsules:",
            *(_capsule_line(index, one) for index, one in enumerate(capsules)),
            "",
            "# Capsules by their place in the list above.",
            *_block("checked_pairs", [_pair_line(p, capsules) for p in pairs if not p.why_not]),
            "",
            *_block("never_checked", list(_left_out(capsules, pairs))),
            "",
        ]
    )


def links_left_out(
    capsules: Sequence[Capsule], pairs: Sequence[CapsulePair]
) -> dict[tuple[str, str], str]:
    """Why, for each two links none of whose capsules are kept apart."""
    why: dict[tuple[str, str], list[str]] = {}
    checked = set()
    for pair in pairs:
        links = capsules[pair.first].link, capsules[pair.second].link
        why.setdefault(links, []).append(pair.why_not)
        if not pair.why_not:
            checked.add(links)
    return {
        links: "; ".join(dict.fromkeys(reasons))
        for links, reasons in why.items()
        if links not in checked
    }


def _block(key: str, lines: Sequence[str]) -> list[str]:
    return [f"{key}:", *lines] if lines else [f"{key}: []"]


def _capsule_line(index: int, capsule: Capsule) -> str:
    a, b = (json.dumps(list(end)) for end in (capsule.a_m, capsule.b_m))
    fields = f"link: {capsule.link}, a_m: {a}, b_m: {b}, radius_m: {capsule.radius_m}"
    return f"  - {{{fields}}}  # {index}"


def _pair_line(pair: CapsulePair, capsules: Sequence[Capsule]) -> str:
    links = f"{capsules[pair.first].link}, {capsules[pair.second].link}"
    return f"  - [{pair.first}, {pair.second}]  # {links}"


def _left_out(capsules: Sequence[Capsule], pairs: Sequence[CapsulePair]) -> Iterator[str]:
    for (one, other), why in links_left_out(capsules, pairs).items():
        yield f"  - links: [{one}, {other}]"
        yield f"    why: {json.dumps(why)}"
