"""One file per format of a record; the suffix of a path picks the file.

Each has ``read(path, request)``, which returns a :class:`~dampyr.records.record.Record`; ``h5`` also writes.
"""
