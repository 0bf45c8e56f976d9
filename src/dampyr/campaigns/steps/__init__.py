"""The kinds of step: one file each, with a dataclass of its name in it (``low_velocity``: ``LowVelocity``).

The dataclass is a `dampyr.campaigns.step.Step`: its fields are what a campaign fills, each with its unit and its words, and it
has ``drive(rig)`` and ``peaks(rig)``. The docstring of the file begins with the kind's name and a colon, and has its path as an
equation.
"""
