"""Instruments of a rig: one folder each, with driver and simulated end.

``driver.py`` has ``connect(rig)``, which gives the instrument; ``simulated.py`` has ``in_process(simulator)``, the instrument
of a simulated rig. What each has to offer is in `contract`. A folder of this package says in its ``ROLE`` what it is for;
another laboratory's lies beside its ``rig.toml``.
"""
