"""How messages travel: the transport and its two forms, the topics, and messages for people.

Everything speaks to a ``Bus``: the Zenoh session between processes, memory within a test. What
is sent is in `fairlead.messages`, under which keys in `fairlead.keys`.
"""
