"""Runs of dry friction, of a dashpot and of a card, and their judgement."""

from dataclasses import replace

import numpy as np

from dampyr.identification import accept
from dampyr.identification.acceptance_tests.acceptance import Acceptance
from dampyr.models import Constant, Damper
from dampyr.records import Record

KX, KW, RHO = 900.0, 150.0, 3000.0

A, HZ = 0.010, 1.0

CARD = Damper("dahl", {"dahl.kx": Constant(KX, 0.0, 0.0), "dahl.kw": KW, "dahl.rho": RHO})


def measured(force, name="test", amplitude=A, hz=HZ, offset=0.0, voltage=0.0, current=None, seconds=6.3):
    """A sine from its middle; ``force(x, v)`` in N."""
    t = np.arange(0.0, seconds / hz, 0.002 / hz)
    x, v = amplitude * np.sin(2 * np.pi * hz * t), 2 * np.pi * hz * amplitude * np.cos(2 * np.pi * hz * t)
    return Record(t, x, force(x, v) + offset, velocity=v, voltage=voltage, current=current, name=name)


def run(card=CARD, share=1.0, **more):
    """What a damper gives that is ``share`` times as strong as the card."""
    made = measured(lambda x, v: 0.0 * x, **more)
    force = card.force(made.time, made.displacement, voltage=0.0, velocity=made.velocity)
    return replace(made, force=share * force + more.get("offset", 0.0))


def dry(c, f):
    return lambda x, v: c * v + f * np.sign(v)


def judge(record, reference, **options) -> Acceptance:
    """The judgement of one record."""
    [result] = accept(record, reference, **options).results
    return result
