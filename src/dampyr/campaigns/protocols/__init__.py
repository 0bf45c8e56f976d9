"""The kinds of protocol: one file each, with a dataclass of its name in it (``peak_velocity``: ``PeakVelocity``).

The dataclass has the numbers that a ``[protocol]`` of a campaign states, and ``steps()`` with the ``[[step]]`` tables that they
stand for, in the order in which they run. The docstring of the file says where the sequence was read.
"""

MEMBERS = "kinds of protocol"
