"""The HAL host: everything a HAL does except talking to its robot."""
