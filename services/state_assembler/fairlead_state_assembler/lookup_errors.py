"""What can be wrong with a lookup, each naming frame, parent and age."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from fairlead.errors import LayoutError


class Claim(NamedTuple):
    """What somebody says of a frame, without the numbers.

    Attributes:
        publisher: who; "" for transforms that came in no message.
        tick: of the newest one.
    """

    publisher: str
    parent: str
    is_static: bool
    tick: int

    def text(self, frame: str) -> str:
        """For example ``hal sends map -> odom (static)``."""
        who, kind = self.publisher or "somebody", "static" if self.is_static else "every tick"
        return f"{who} sends {self.parent} -> {frame} ({kind})"


def not_yet(parent: str, frame: str, first: int, tick: int) -> LayoutError:
    """The frame is known, but only from a later tick on."""
    return LayoutError(
        f"transforms: {parent} -> {frame} is known from tick {first} on, not at tick {tick}",
        kind="missing_tick",
        name=frame,
        parent=parent,
    )


def contested(frame: str, owner: str, known: Claim | None, rival: Claim) -> LayoutError:
    """Two publishers send the frame, or one sends it in two ways.

    Args:
        owner: who may send it; "" for whoever came first.
        known: what was taken before; None for nothing yet.
    """
    first = known.text(frame) if known else f"{owner} is to send it"
    rule = "a frame has one parent, and is static or not"
    if rival.publisher != (known.publisher if known else owner):
        rule = f"only {owner or 'one of them'} may send it"
    return LayoutError(
        f"transforms: frame {frame!r} is contested: {first}, {rival.text(frame)}; {rule}",
        kind="contested_frame",
        name=frame,
        parent=known.parent if known else rival.parent,
        is_certain=True,
    )


def stale(
    known: Claim, frame: str, newest: int, tick: int, allowed: int, dropped_by: str
) -> LayoutError:
    """The newest transform is older than it may be.

    Args:
        newest: the last tick up to ``tick`` that has one.
        dropped_by: who sent the frame and has sent a batch of ``tick`` or later without it;
            "" if that batch may still come.
    """
    dropped = f"; {dropped_by} sends its transforms without it now" if dropped_by else ""
    sender = f" (from {known.publisher})" if known.publisher else ""
    return LayoutError(
        f"transforms: {known.parent} -> {frame}{sender} is stale at tick {tick}: the newest "
        f"before it is {tick - newest} tick(s) old, allowed {allowed}{dropped}",
        kind="stale_frame",
        name=frame,
        parent=known.parent,
        age_ticks=tick - newest,
        is_certain=bool(dropped_by),
    )


def loop(frame: str, asked_from: str, path: Sequence[str]) -> LayoutError:
    """The frame's parents lead back to themselves."""
    return LayoutError(
        f"transforms: frame {frame!r} hangs in a loop: {' -> '.join(path)}",
        kind="loop",
        name=frame,
        parent=asked_from,
        is_certain=True,
    )


def unconnected(
    parent: str,
    child: str,
    roots: tuple[str, str],
    known: Collection[str],
    owed: Sequence[tuple[str, str]],
) -> LayoutError:
    """One of the frames is unknown, or they hang in different trees.

    Args:
        roots: of ``parent``'s tree and of ``child``'s tree.
        owed: those of them that a publisher is to send, and has not.
    """
    missing, origin = (child, parent) if child not in known else (parent, child)
    if missing not in known:
        listed = ", ".join(sorted(known)) or "none"
        text = f"no frame {missing!r} (looked up from {origin!r}); known: {listed}"
    else:
        missing, origin = roots[1], parent
        text = (
            f"{child!r} is not connected to {parent!r}: nothing says where its root "
            f"{roots[1]!r} is in {roots[0]!r}"
        )
    text += "".join(f"; {who} has not sent {frame!r} (tf/{who})" for frame, who in owed)
    return LayoutError(f"transforms: {text}", kind="missing_frame", name=missing, parent=origin)
