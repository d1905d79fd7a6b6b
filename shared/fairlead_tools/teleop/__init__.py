"""A person drives: an input device, what it may ask of the robot, the claim that carries it."""
