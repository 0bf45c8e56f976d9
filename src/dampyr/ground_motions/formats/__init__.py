"""Formats of ground motions: one file each, with ``SUFFIXES`` and ``read(path, units, dt) -> GroundMotion``.

A format of texts whose columns can be declared has ``TAKES_OPTIONS = True`` and ``read(path, units, dt, options)``.
"""
