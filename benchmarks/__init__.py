"""Timings on this machine, printed and never asserted: ``python -m benchmarks``, or ``make bench``.

A bench is one file of this folder, found by its name, with a ``TITLE`` and a function
``run(data: Path | None) -> list[Line] | str``: its lines, or in one sentence why it was left out. ``data`` is the folder of
measured data (``DAMPYR_DATA``, else ``../shared/data`` beside the repository), or None. Every bench runs dampyr and its peers
in turn, in the same process and on the same problem, and says how far each is from the answer: a time without an error
means nothing. A bench with ``OPT_IN = True`` takes long and is run by its name only.
"""
