"""The machine: settings, drivers, acquisition, safety layers, and its simulated twin.

::

    with dp.rig.simulated() as rig, rig.armed() as table:     # or dp.rig.connect("rig.toml")
        table.home()
        table.go(0.005)
"""

from dampyr.rig.connecting import connect, simulated
from dampyr.rig.drive import Drive, DutyReversals
from dampyr.rig.session import Rig
from dampyr.rig.settings import RigSettings, load_settings

__all__ = [
    "Drive", "DutyReversals", "Rig", "RigSettings", "connect", "load_settings", "simulated",
]  # fmt: skip
