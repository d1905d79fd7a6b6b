"""``fairlead serve-policy SKILL``: a skill's policy for others, over openpi's protocol."""

from __future__ import annotations

import asyncio
import os
from typing import Annotated

import typer

from fairlead.errors import ConfigError, expected
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.options import example
from fairlead_tools.cli.skill import SkillArgument, installed_skill


@example("fairlead serve-policy oracle-counter-to-cabinet --port 8000")
def serve_policy_command(
    skill: SkillArgument,
    host: Annotated[str, typer.Option(help="address to listen on")] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="0: any that is free; it is printed")
    ] = 8000,
    state_key: Annotated[str, typer.Option(help="name of the state")] = "observation/state",
    prompt_key: Annotated[str, typer.Option(help="name of the prompt")] = "prompt",
    api_key_env: Annotated[
        str, typer.Option(metavar="NAME", help="environment variable with the key clients need")
    ] = "",
) -> None:
    """Serve SKILL's policy to one client at a time, by the openpi websocket protocol.

    No robot and no gate: the client decides what becomes of the rows. Ends with Ctrl-C.
    """
    key = os.environ.get(api_key_env, "") if api_key_env else None
    if key is not None and (not key or not key.isprintable()):
        who = "serve-policy: --api-key-env"
        raise ConfigError(expected(who, f"one line in {api_key_env}", "nothing or more"))
    keys = (state_key, prompt_key)
    asyncio.run(_serve(load_skill(installed_skill(skill)), host, port, keys, key))


async def _serve(
    skill: SkillManifest, host: str, port: int, keys: tuple[str, str], api_key: str | None
) -> None:
    from fairlead_skill_runner import PolicyServer, served_policy

    server = PolicyServer(skill, served_policy(skill), keys, api_key, lambda line: echo(line))
    try:
        opened = await server.listen(host, port)
    except OSError as error:
        where = f"--host {host} --port {port}"
        raise ConfigError(f"serve-policy: {where}: cannot listen: {error.strerror}") from None
    async with opened as listening:
        where = next(iter(listening.sockets)).getsockname()
        echo(f"{skill.id}: listening on ws://{where[0]}:{where[1]}")
        await asyncio.Event().wait()
