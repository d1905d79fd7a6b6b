"""What a robot really does when it is driven: ``fairlead robot measure``."""
