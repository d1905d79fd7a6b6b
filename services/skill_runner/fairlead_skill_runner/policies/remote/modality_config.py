"""What an RLDX or GR00T server says that it wants and gives, and which release's wire it speaks.

The answer to ``get_modality_config`` tells the releases apart:

=====================  ==========================================  =============================
marker of an entry     release                                     requests and arrays
=====================  ==========================================  =============================
__ModalityConfig__     GR00T N1.7 since 3df8b38                    arrays ``nd``
__ModalityConfig_class__, as_json a map
                       RLDX-1, GR00T N1.6, N1.7 at its release     arrays ``npy``
__ModalityConfig_class__, as_json a text
                       GR00T N1.5                                  arrays ``npy``, no batch axis
=====================  ==========================================  =============================
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

import msgspec

from fairlead.errors import PolicyError, expected
from fairlead_skill_runner.policies.remote.rldx_wire import Arrays

OLDER, NEWER = "__ModalityConfig_class__", "__ModalityConfig__"


class Dialect(Enum):
    """A family of releases that speak alike."""

    N1_5 = "GR00T N1.5"
    CLASS = "RLDX-1, GR00T N1.6 or N1.7 at its release"
    ND = "GR00T N1.7 after 3df8b38"

    @property
    def arrays(self) -> Arrays:
        """How arrays are sent to it."""
        return "nd" if self is Dialect.ND else "npy"


class Modality(msgspec.Struct, frozen=True):
    """One kind of input or output: its names, and the deltas in rows of the policy."""

    delta_indices: tuple[int, ...]
    modality_keys: tuple[str, ...]


class ServerConfig(NamedTuple):
    """The server's answer; modalities are video, state, action and language, as far as told."""

    dialect: Dialect
    modalities: Mapping[str, Modality]


def read_config(who: str, answer: object) -> ServerConfig:
    """Understand an answer to ``get_modality_config``; an empty one tells nothing.

    Raises:
        PolicyError: for anything else.
    """
    if not isinstance(answer, dict):
        raise PolicyError(expected(who, "a map of modalities", type(answer).__name__))
    dialect, found = Dialect.CLASS, {}
    for kind, entry in answer.items():
        blocks = entry if isinstance(entry, dict) else {}
        if NEWER in blocks:
            dialect = Dialect.ND
        elif isinstance(blocks.get("as_json"), str):
            dialect = Dialect.N1_5
        found[str(kind)] = _modality(who, str(kind), blocks.get("as_json", entry))
    return ServerConfig(dialect, found)


def _modality(who: str, kind: str, block: object) -> Modality:
    try:
        made = (
            msgspec.json.decode(block, type=Modality)
            if isinstance(block, str)
            else msgspec.convert(block, Modality)
        )
    except (msgspec.ValidationError, msgspec.DecodeError) as error:
        raise PolicyError(f"{who}: modality {kind}: {error}") from None
    prefix = f"{kind}."  # N1.5 has it in its names
    keys = tuple(key.removeprefix(prefix) for key in made.modality_keys)
    return Modality(made.delta_indices, keys)
