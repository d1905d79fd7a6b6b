"""Recording a run from outside, and the picture and video made of it."""
