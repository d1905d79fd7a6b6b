"""A deployment on all its hosts: what is wrong before anything starts, and units for systemd."""
