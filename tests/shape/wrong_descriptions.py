"""A robot's description, wrong on purpose: the mistakes of whoever mixes a URDF and a model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Mistake:
    """Text of ``panda.urdf`` and what stands there instead, and the first frame that is off."""

    edits: tuple[tuple[str, str], ...]
    frame: str


_ELBOW = """<origin xyz="0.0825 0 0" rpy="1.5707963267948966 0 0"/>
    <axis xyz="0 0 1"/>"""
_FOREARM = '<origin xyz="-0.0825 0.384 0" rpy="-1.5707963267948966 0 0"/>'
_UPPER_ARM = '<origin xyz="0 0 0" rpy="-1.5707963267948966 0 0"/>'
_NEXT = '<origin xyz="0 -0.316 0" rpy="1.5707963267948966 0 0"/>'

MISTAKES: Mapping[str, Mistake] = {
    "forearm 0.2 m longer": Mistake(((_FOREARM, _FOREARM.replace("0.384", "0.584")),),
                                    "panda_link5"),
    "tool 0.1 m shorter": Mistake((('xyz="0 0 0.1034"', 'xyz="0 0 0.0034"'),), "panda_hand_tcp"),
    "wrist joints swapped": Mistake(
        (('name="panda_joint5"', 'name="other"'), ('name="panda_joint7"', 'name="panda_joint5"'),
         ('name="other"', 'name="panda_joint7"')), "panda_link5"),
    "elbow axis flipped": Mistake(((_ELBOW, _ELBOW.replace('"0 0 1"', '"0 0 -1"')),),
                                  "panda_link4"),
    # What hangs on it is where it was: only this frame, and the capsules in it, are wrong.
    "a link turned by 180 degrees": Mistake(
        ((_UPPER_ARM, _UPPER_ARM.replace("-1.57", "1.57") + "<axis xyz=\"0 0 -1\"/><!--"),
         ('<limit lower="-1.7628"', '--><limit lower="-1.7628"'),
         (_NEXT, '<origin xyz="0 0.316 0" rpy="-1.5707963267948966 0 0"/>')), "panda_link2"),
}  # fmt: skip


def mistaken(urdf: str, mistake: Mistake) -> str:
    """The description with one of the mistakes."""
    for old, new in mistake.edits:
        assert urdf.count(old) == 1, old
        urdf = urdf.replace(old, new)
    return urdf
