"""Why the gate decided what it did: its own explanation, in words, with the limit's place.

What ``fairlead why`` prints: the gate's program reads its decision log and explains a decision;
here it is read, put into words and traced to the key of ``robot.yaml`` that declares the limit.
"""
