"""What can be wrong with a lookup, each naming frame, parent and age."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from fairlead.errors import LayoutError


def not_yet(parent: str, frame: str, first: int, tick: int) -> LayoutError:
    """The frame is known, but only from a later tick on."""
    return LayoutError(
        f"transforms: {parent} -> {frame} is known from tick {first} on, not at tick {tick}",
        kind="missing_tick",
        name=frame,
        parent=parent,
    )


def stale(
    parent: str, frame: str, newest: int, tick: int, allowed: int, dropped_by: str
) -> LayoutError:
    """The newest transform is older than it may be.

    Args:
        dropped_by: who sent the frame and has sent a batch of ``tick`` or later without it;
            "" if that batch may still come.
    """
    dropped = f"; {dropped_by} sends its transforms without it now" if dropped_by else ""
    return LayoutError(
        f"transforms: {parent} -> {frame} is stale at tick {tick}: the newest before it "
        f"is {tick - newest} tick(s) old, allowed {allowed}{dropped}",
        kind="stale_frame",
        name=frame,
        parent=parent,
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
    parent: str, child: str, roots: tuple[str, str], known: Collection[str]
) -> LayoutError:
    """One of the frames is unknown, or they hang in different trees.

    Args:
        roots: of ``parent``'s tree and of ``child``'s tree.
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
    return LayoutError(f"transforms: {text}", kind="missing_frame", name=missing, parent=origin)
