"""The kinds of step: one file each, with a dataclass of its name in it (``low_velocity``: ``LowVelocity``)."""
