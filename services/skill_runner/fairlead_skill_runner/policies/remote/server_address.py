"""How the address of a policy server is written, for each protocol."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class AddressForm(NamedTuple):
    """A regular expression for the whole address, and an example of one."""

    pattern: str
    example: str


ADDRESS_FORMS: Mapping[str, AddressForm] = {
    "openpi": AddressForm(r"^wss?://[^/\s]+(/\S*)?$", "ws://127.0.0.1:8000"),
    "rldx_zmq": AddressForm(r"^tcp://[^/\s:]+:\d+$", "tcp://127.0.0.1:5555"),
}
"""Policy backend -> form of its address; backends without a server are not in it."""
