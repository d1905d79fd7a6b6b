"""The command line ``fairlead``: one file a group of commands, put together in `app`."""
