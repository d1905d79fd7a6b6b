"""What must be true of every line a HAL wrote, whatever was done to the robot."""

from __future__ import annotations

from bench.equipment.live_robot import LiveRobot


def every_row_was_judged_for_its_tick(robot: LiveRobot) -> None:
    """Over the whole log: no row late, none twice, none resumed after a hold.

    Row k of a released chunk may act only in its first tick plus k; and a part that held
    moves again only by a verdict that had not acted before the hold.
    """
    newest: dict[int, int] = {}
    spent: dict[tuple[int, int], set[int]] = {}  # (session, part): verdicts ended by a hold
    acting: dict[tuple[int, int], set[int]] = {}
    checked = 0
    for line in robot.motion.read():
        before = newest.get(line.session, 0)
        # A tick that was decided and then held after all has a second line, which says so.
        assert line.tick > before or (line.tick == before and not line.moves), line
        newest[line.session] = line.tick
        for index, (hold, (verdict, row)) in enumerate(zip(line.holds, line.rows, strict=True)):
            part = (line.session, index)
            if hold:
                spent.setdefault(part, set()).update(acting.pop(part, set()))
                continue
            assert verdict not in spent.get(part, set()), f"{verdict:x} resumed after a hold"
            acting.setdefault(part, set()).add(verdict)
            if verdict in robot.first_ticks:  # a watcher may miss a message, too
                assert line.tick == robot.first_ticks[verdict] + row
                checked += 1
    assert checked > 0


def no_old_row_acts(robot: LiveRobot, woken_ns: int) -> None:
    """After something slept, no verdict acts that had acted before it woke."""
    lines = robot.motion.read()
    old = {v for line in lines if line.stamp_ns < woken_ns for v in line.verdicts}
    assert old, "nothing had acted before"
    for line in lines:
        if line.stamp_ns >= woken_ns:
            assert not line.verdicts & old, "a row from before the sleep acted after it"
