"""``fairlead layout``: the state vectors that policies get."""

from __future__ import annotations

from fairlead_tools.cli import layout_ls, layout_verify
from fairlead_tools.cli.group import make_group

group = make_group(
    "layout",
    "List state layouts and verify them against simulator truth.",
    {"ls": layout_ls, "verify": layout_verify},
)
