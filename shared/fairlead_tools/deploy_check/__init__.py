"""Finds what is wrong with a deployment on all its hosts, before anything starts."""
