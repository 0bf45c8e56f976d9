"""Formats of a record, one file each; the suffix of a path selects the file.

Each has ``read(path, request)``, which returns a :class:`~dampyr.records.record.Record`; those that can also write have
``write(record, path)``. ``PLAIN_TEXT = True`` marks a format whose files may be prose: those without a line of numbers are
left out of a folder. ``NEEDS_VELOCITY = True`` marks one that can hold a record only with its velocity. ``parts(path)`` gives
what ``variable`` is of each record in a file that holds several, all of which a folder reads. ``TITLE`` is what people call the
format (by default its suffix in capitals), ``MEDIA_TYPE`` what a browser does.
"""
