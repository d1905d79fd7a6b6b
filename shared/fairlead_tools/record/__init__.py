"""Recording a run from outside, and the picture and film made of it."""
