"""How the processes of a robot find each other, wait for each other and end.

Deployment files (``compose/*.yaml``), the hosts they name, what a service says while the router
is away, the signals that end it, and the list of what runs on this machine.
"""
