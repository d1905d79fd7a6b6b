"""Does a running HAL keep the contract? ``fairlead hal check``."""
