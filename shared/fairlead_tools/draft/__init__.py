"""A first robot folder, drafted from the MJCF and URDF files that a person has."""
