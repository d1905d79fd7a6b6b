"""The layouts that ship, one file each; ``pyproject.toml`` registers them."""
