"""The HAL of robots that run ROS 2 on rmw_zenoh, ``run: hal_ros2`` in a deployment file.

Nothing in here is for others to import; robots are connected through `fairlead.hal`.
"""

__all__: list[str] = []
