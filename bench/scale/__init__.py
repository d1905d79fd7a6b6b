"""How many robots one router carries: see `bench.scale.__main__`."""
