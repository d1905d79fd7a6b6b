"""Hardware that is not there: servos on a bus, as bytes on a pseudo-terminal."""
