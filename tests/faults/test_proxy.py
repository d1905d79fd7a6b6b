"""The fault proxy does to a stream of batches what its rules say, and no more."""

from __future__ import annotations

import random
import socket
import threading
import time
from collections.abc import Iterator
from itertools import pairwise

import pytest

from bench.equipment.live_robot import wait_for
from bench.faults.proxy import (
    FaultProxy,
    Rule,
    corrupts,
    delays,
    doubles,
    drop,
    forward,
    keeps_every,
    loses,
    lossy,
    stalls,
    swaps,
)  # fmt: skip

COUNT = 40


class Ends:
    """A client that writes through the proxy, and what the other end has read."""

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self.proxy = FaultProxy(self._server.getsockname()[1])
        self.link_again()

    def link_again(self) -> None:
        """The client's link to the proxy, made anew; nothing of it is read yet."""
        self.read: list[int] = []
        self.client = socket.create_connection(("127.0.0.1", self.proxy.port))
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        connection, _ = self._server.accept()
        with connection, connection.makefile("rb") as stream:
            while len(head := stream.read(2)) == 2:
                self.read.append(int.from_bytes(stream.read(int.from_bytes(head, "little"))[:2]))

    def write(self, numbers: range) -> None:
        for number in numbers:
            batch = number.to_bytes(2) + bytes(30)
            self.client.sendall(len(batch).to_bytes(2, "little") + batch)

    def all_read(self) -> list[int]:
        """Everything that arrived until the client ended its connection."""
        self.client.shutdown(socket.SHUT_WR)
        self._reader.join(10.0)
        assert not self._reader.is_alive()
        return self.read

    def close(self) -> None:
        with self.proxy, self.client, self._server:
            pass


@pytest.fixture
def ends() -> Iterator[Ends]:
    ends = Ends()
    yield ends
    ends.close()


RULES: dict[str, tuple[Rule, list[int]]] = {
    "a good network": (forward, [0, 1, 2, 3]),
    "a partition": (drop, []),
    "doubled": (doubles, [0, 0, 1, 1, 2, 2, 3, 3]),
    "overtaken": (swaps(), [1, 0, 3, 2]),
    "one of three kept": (keeps_every(3), [2]),
}


@pytest.mark.parametrize("name", RULES)
def test_a_rule_decides_what_arrives(ends: Ends, name: str) -> None:
    rule, expected = RULES[name]
    ends.proxy.set("up", rule)
    ends.write(range(4))
    assert ends.all_read() == expected


def test_a_share_of_messages_is_lost(ends: Ends) -> None:
    ends.proxy.set("up", loses(0.5, random.Random(1)))
    ends.write(range(COUNT))
    arrived = ends.all_read()
    assert arrived == sorted(arrived) and 0 < len(arrived) < COUNT


def test_some_messages_are_lost_and_some_overtaken_by_the_next(ends: Ends) -> None:
    ends.proxy.set("up", lossy(0.2, 0.2, random.Random(3)))
    ends.write(range(COUNT))
    arrived = ends.all_read()
    assert COUNT // 2 < len(arrived) < COUNT
    late = [a for a, b in pairwise(arrived) if a > b]
    assert late and sorted(set(arrived)) == sorted(arrived)


def test_delayed_messages_arrive_later_and_overtake_each_other(ends: Ends) -> None:
    ends.proxy.set("up", delays(0.1, 0.05, random.Random(1)))
    began = time.monotonic()
    ends.write(range(COUNT))
    arrived = ends.all_read()
    assert sorted(arrived) == list(range(COUNT)) != arrived
    assert time.monotonic() - began >= 0.1


def test_a_stall_keeps_the_order_and_ends_at_once_for_all(ends: Ends) -> None:
    ends.proxy.set("up", stalls(0.1))
    began = time.monotonic()
    ends.write(range(COUNT))
    assert ends.all_read() == list(range(COUNT))
    assert time.monotonic() - began >= 0.1


def test_a_wrong_bit_changes_one_message_and_not_its_length(ends: Ends) -> None:
    ends.proxy.set("up", corrupts(1.0, random.Random(1)))
    ends.write(range(COUNT))
    assert len(ends.all_read()) == COUNT


def test_a_rule_may_spare_the_links_that_are_made_later(ends: Ends) -> None:
    ends.write(range(1))
    wait_for(lambda: ends.read == [0], "the first link is open")
    ends.proxy.set("up", drop, new_links=forward)
    ends.write(range(1, 4))
    assert ends.all_read() == [0]
    ends.client.close()
    ends.link_again()
    ends.write(range(4))
    assert ends.all_read() == [0, 1, 2, 3]


def test_one_direction_can_be_dead_alone(ends: Ends) -> None:
    ends.proxy.set("down", drop)
    ends.write(range(4))
    assert ends.all_read() == [0, 1, 2, 3]
