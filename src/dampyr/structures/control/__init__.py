"""Semi-active control laws, one file each: how a controller sets the input of a damper from what it measures.

`dampyr.structures.law_form` says what a file holds: a class of settings, what it measures, and formulas. Every law has the
settings ``low`` and ``high``, the least and the greatest input, ``period`` s, after which it decides again (the input is held
between), ``lag`` s, the time constant of the coil behind it (0: the coil follows at once), ``sensors`` and the ``seed`` of
their noise.
"""

MEMBERS = "control laws"
