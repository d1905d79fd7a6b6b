"""How the processes of a robot find each other, wait for each other and end.

Deployment files (``compose/*.yaml``), the hosts they name, what a service says while the router
is away, and the signals that end it. Starting and watching the processes of a host is
`fairlead.supervisor`.
"""
