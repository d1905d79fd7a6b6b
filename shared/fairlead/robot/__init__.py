"""What a robot is and what it may do: ``robots/<id>/robot.yaml``, and what is made of it.

The manifest and its blocks (joints, parts, the limits of each profile and mode), the rules that
concern more than one of them, and the file the gate loads.
"""
