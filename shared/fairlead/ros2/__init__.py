"""A ROS 2 system as its middleware rmw_zenoh has it on Zenoh: for HALs and bridges.

What is on the wire is that middleware's: its docs/design.md says how keys, tokens and attachments
are made, and `fairlead.ros2.grammar` makes them.
"""
