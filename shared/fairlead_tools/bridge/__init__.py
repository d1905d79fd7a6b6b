"""What shows a robot of ours to another system."""
