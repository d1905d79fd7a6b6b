"""What a service behind a router says and refuses."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Iterator

import pytest

from fairlead.deploy.router_watch import open_with_logging, refuse_duplicate_service, watch_router
from fairlead.errors import ConfigError, TransportError
from fairlead.keys import Keys
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus
from fairlead_tools.supervisor.this_host import free_ports
from tests.client.turns import turns, until

LOG = logging.getLogger("runner")
TOKEN = Keys("r").alive("runner")


@pytest.fixture
def endpoint() -> str:
    return f"tcp/127.0.0.1:{free_ports(1)[0]}"


@pytest.fixture
def client_of(endpoint: str) -> Endpoints:
    return Endpoints(connect=[endpoint], mode="client", router_host="robot")


@pytest.fixture
def router(endpoint: str) -> Iterator[ZenohBus]:
    bus = ZenohBus(Endpoints(listen=[endpoint], mode="router"))
    yield bus
    bus.close()


def test_a_tool_is_told_which_router_it_cannot_reach(client_of: Endpoints) -> None:
    with pytest.raises(TransportError) as caught:
        ZenohBus(client_of)
    assert str(caught.value) == (
        f"router {client_of.connect[0]}: not reached within 2 s; does it run on host robot, and "
        "is the network up? there: fairlead up or fairlead router"
    )


@pytest.mark.asyncio
async def test_a_service_waits_for_its_router_and_says_so_once(
    endpoint: str, client_of: Endpoints, caplog: pytest.LogCaptureFixture
) -> None:
    opening = asyncio.create_task(open_with_logging(client_of, LOG))
    await until(lambda: caplog.records)
    router = ZenohBus(Endpoints(listen=[endpoint], mode="router"))
    opened = await opening
    assert opened.has_router
    assert len(caplog.messages) == 1
    assert caplog.messages[0].startswith(f"waiting: router {endpoint}: not reached")
    opened.close()
    router.close()


@pytest.mark.asyncio
async def test_a_namesake_behind_the_same_router_is_refused(
    router: ZenohBus, client_of: Endpoints
) -> None:
    first, second = ZenohBus(client_of), ZenohBus(client_of)
    await refuse_duplicate_service("runner", first, TOKEN)
    first.declare_token(TOKEN)
    await until(lambda: second.is_declared(TOKEN))
    with pytest.raises(ConfigError, match="another runner of this robot is alive behind the same"):
        await refuse_duplicate_service("runner", second, TOKEN)
    first.close()
    await refuse_duplicate_service("runner", second, TOKEN)
    second.close()


@pytest.mark.asyncio
async def test_a_lost_router_is_named_and_so_is_its_return(
    endpoint: str, client_of: Endpoints, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    router = ZenohBus(Endpoints(listen=[endpoint], mode="router"))
    bus = ZenohBus(client_of)
    watching = asyncio.create_task(watch_router(bus, endpoint, LOG))
    await turns()  # it begins with the router there
    router.close()
    await said(caplog, "lost the router")
    router = ZenohBus(Endpoints(listen=[endpoint], mode="router"))
    await said(caplog, f"the router {endpoint} is back")
    watching.cancel()
    bus.close()
    router.close()


async def said(caplog: pytest.LogCaptureFixture, text: str) -> None:
    await until(lambda: any(text in line for line in caplog.messages))
