"""What a policy needs and what it emits: ``rskills/<id>/rskill.yaml``, and what is made of it.

The manifest and its blocks (state vector, action vector, slots), how the slots are routed on
one robot, and whether the skill may run there at all.
"""
