"""Times that must keep their order."""

from __future__ import annotations

from fairlead.operate.services import ANSWER_TIMEOUT_S
from fairlead.wire.endpoints import LINK_SILENCE_S


def test_a_tool_waits_for_an_answer_longer_than_a_silent_link_lives() -> None:
    # A router that pauses delivers what it holds when it goes on, unless the link to the gate was
    # closed meanwhile. Were the link to outlive the wait, a query to arm could be delivered, and
    # the gate armed, after the tool told its user that it was not.
    assert ANSWER_TIMEOUT_S > LINK_SILENCE_S
