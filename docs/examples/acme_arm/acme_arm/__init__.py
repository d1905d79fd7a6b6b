"""Acme's arm of two joints, for fairlead."""
