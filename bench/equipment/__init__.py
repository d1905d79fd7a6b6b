"""Gates, robots and episodes that programs and tests run: the real ones, with a handle on them."""
