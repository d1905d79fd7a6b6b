"""Whether rows run out: a slow policy over a bad network, in realtime, beside simpler executors."""
