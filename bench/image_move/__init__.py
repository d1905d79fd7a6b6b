"""Pictures from a camera's process to an array in another: fairlead, a floor, dora-rs."""
