"""Makes, renews and revokes what proves names between hosts."""
