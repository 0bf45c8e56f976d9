"""Semi-active control laws, one file each: how a controller sets the input of a damper from what it senses.

A law is a frozen dataclass of its settings and two short functions:

``gains(law, building, row)``
    what it senses of the building, (2n + 1,): the factors of the floors' displacements and velocities relative to the
    ground, and of the ground's own velocity; their sum is the ``signal``. ``row`` (n,) turns floor displacements into the
    stroke of the damper.
``decide(signal, stroke, rate, force, settings...)``
    the input from then on, in V or A as the damper takes it; of the stroke [m], its rate [m/s], the force of the damper [N,
    positive against positive rate] and the settings, it names those that it uses.

Every law has the settings ``low`` and ``high``, the least and the greatest input, ``period`` s, after which it decides again
(the input is held between), and ``lag`` s, the time constant of the coil behind it (0: the coil follows at once).
"""

MEMBERS = "control laws"
