"""The messages behind the golden bytes: what every codec of this project must agree on.

Each type has one ``rich`` instance in which no two fields are equal, so that a codec that
swaps two fields fails, and edge instances where the encoding changes width or shape.
``MESSAGES`` maps the name of the file (without ``.bin``) to the message.
"""

from __future__ import annotations

from fairlead.messages import Message
from tests.golden.action_messages import ACTION
from tests.golden.gate_messages import SAFETY
from tests.golden.query_messages import QUERY
from tests.golden.state_messages import STATE

MESSAGES: dict[str, Message] = {**STATE, **ACTION, **SAFETY, **QUERY}
