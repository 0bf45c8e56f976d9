"""The response of a building to one ground motion."""
