"""Formats of ground motions: one file each, with ``SUFFIXES`` and ``read(path, units, dt) -> GroundMotion``."""
