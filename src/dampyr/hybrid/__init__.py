"""Hybrid tests: a structure of which one part is a specimen in a testing machine, and the rest is computed, step by step.

The computed part (the numerical substructure) gives the displacement that the machine (the transfer system) has to impose on
the specimen, and the force that is measured goes back into the computation. Here the machine and the specimen are simulated
too, with their noise, converters and delays: a virtual hybrid test. One of a damper on the rig is a step of a campaign
(`dampyr.campaigns.steps.hybrid`, ``dampyr hybrid``): `dampyr.campaigns.planned_hybrid` plans it, and
`dampyr.campaigns.hybrid_result` says what its record has shown. `Substructure` is its computed part, and `run_delayed` runs it
on an actuator that is late by a fixed time.

::

    setup = HybridSetup(structure, PhysicalSubstructure(29.13, 1.19e6, 0.0097), TransferSystem())
    loop_stability(setup, compensator).stable       # told before anything runs
    run = perform_virtual(setup, compensator, motion)
    run.criteria()                                  # J1 to J9 of the benchmark, judged on the true displacement
    run_many(setup, compensator, motion, 1000)      # over random plants, in parallel threads
"""

from dampyr.hybrid.compensators import KalmanCompensator, ModelBasedCompensator, PhaseLeadCompensator
from dampyr.hybrid.delayed_actuator import run_delayed
from dampyr.hybrid.random_plants import run_many
from dampyr.hybrid.setup import HybridSetup, PhysicalSubstructure, PlantSpread, Sensors, TransferSystem
from dampyr.hybrid.stability import loop_stability
from dampyr.hybrid.substructure import Substructure
from dampyr.hybrid.virtual_test import perform_virtual

__all__ = [
    "HybridSetup", "PhysicalSubstructure", "TransferSystem", "Sensors", "PlantSpread", "PhaseLeadCompensator",
    "ModelBasedCompensator", "KalmanCompensator", "loop_stability", "perform_virtual", "run_many", "Substructure",
    "run_delayed",
]  # fmt: skip
