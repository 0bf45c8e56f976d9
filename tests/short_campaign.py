"""A campaign of two short sines, for tests of what performs it."""

SHORT = """
name = "short"
rest_between = "0.2 s"
check_amplitude = 0.0
[[step]]
kind = "sine"
amplitude = "4 mm"
frequency = "1 Hz"
voltage = ["0 V", "0.8712 V"]
cycles = 2
rest_before = "0.2 s"
"""
FIRST, SECOND = "01-sine-4mm-1Hz-0V", "02-sine-4mm-1Hz-0.8712V"
