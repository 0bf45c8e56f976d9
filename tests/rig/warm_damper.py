"""A damper that is soon warm, and a test that warms it."""

from dataclasses import replace

from dampyr.rig import RigSettings

SETTINGS = replace(
    RigSettings(),
    specimen=replace(RigSettings().specimen, heat_capacity=20.0),
    limits=replace(RigSettings().limits, temperature=26.0),
)
HOT = """
rest_between = "0.1 s"
check_amplitude = "0 mm"
[[step]]
kind = "sine"
amplitude = "8 mm"
frequency = "1 Hz"
voltage = "1.5 V"
cycles = 20
repeats = 2
rest_before = "0.2 s"
"""
