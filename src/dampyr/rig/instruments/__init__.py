"""Drivers of the instruments: NI board, Arduino Uno, and the wire to it."""
