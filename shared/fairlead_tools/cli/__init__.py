"""The command line ``fairlead``: one file a command, named after it."""
