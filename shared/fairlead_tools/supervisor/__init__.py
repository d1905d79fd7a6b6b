"""Starts, watches, restarts and stops the processes of one deployment on this host.

It never talks to them: whether a process lives and what it prints is all it knows, so
the same code runs services that are broken. No service outlives it: each gets SIGKILL
from the kernel when the supervisor dies, however that happens. What a service started
ends with it, unless it has left the service's process group.
"""

from fairlead_tools.supervisor.supervisor import ServiceEvent, Supervisor

__all__ = ["ServiceEvent", "Supervisor"]
