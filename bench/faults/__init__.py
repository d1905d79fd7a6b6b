"""What happens when parts of a running robot fail? ``python -m bench.faults``."""
