"""The range of numbers that the wire can carry, for options that end up in a message."""

MAX_NUMBER = 2**64 - 1  # an unsigned 64-bit integer
