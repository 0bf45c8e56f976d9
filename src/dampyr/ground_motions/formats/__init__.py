"""Formats of ground motions: one file each, of two kinds.

A plain one has ``SUFFIXES`` and ``read(path, units, dt) -> GroundMotion`` and is chosen by the suffix; one of texts whose
columns can be declared has ``TAKES_OPTIONS = True`` and ``read(path, units, dt, options)``. One that is known by its first
lines has ``recognises(lines) -> bool``, ``SIGNATURE``, what these are in words, ``TITLE`` and ``channels(path, lines) ->
list[MotionChannel]``, every component of the file; it is chosen by content, whatever the suffix. Its ``SUFFIXES`` are those by
which people know it, and a file of such a suffix with other content is refused.
"""
