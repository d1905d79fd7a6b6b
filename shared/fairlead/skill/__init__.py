"""What a policy needs and what it emits: ``rskills/<id>/rskill.yaml``, and what is made of it.

The manifest and its blocks (state vector, action vector, slots), how the slots are routed on
one robot, whether the skill may run there at all, and how a skill is begun and installed.
"""
