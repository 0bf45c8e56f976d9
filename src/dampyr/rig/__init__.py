"""The machine: what it is made of, how it is driven and read, what keeps it safe, and its simulated twin."""

from dampyr.rig.drive import Drive, Reversals
from dampyr.rig.settings import RigSettings, load_settings

__all__ = ["Drive", "Reversals", "RigSettings", "load_settings"]
