"""The tools above the services: the command line, and what its commands are made of.

A robot runs without it: no service imports it, nor does a client that talks to a robot.
"""

__all__: list[str] = []
