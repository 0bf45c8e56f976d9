"""The instruments: one file each, the driver for the real one beside its end of the simulated rig."""
