"""The simulated rig: one plant that behaves as the original shaking table with its damper, and the ends of its two wires."""
