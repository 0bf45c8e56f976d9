"""Make a damper of my own numbers over the voltage, compute its force along a path, save its card and load it again."""

from pathlib import Path

import numpy as np

import dampyr as dp

t = np.linspace(0.0, 3.0, 3001)
x = 0.010 * np.sin(2 * np.pi * 1.0 * t)  # m

constant = dp.models.Damper("dahl + spring", {"dahl.kx": 1200.0, "dahl.kw": 180.0, "dahl.rho": 8000.0, "spring.k0": 500.0})
print(f"constant damper: {constant.force(t, x).max():.1f} N")

Path("own.toml").write_text("""
schema = 1
[damper]
parts = ["dahl"]
input = "V"
[laws."dahl.kx"]
kind = "interpolation"
knots = [0.0, 1.0, 2.0]
values = [900.0, 1800.0, 3000.0]
[laws."dahl.kw"]
kind = "polynomial"
coefficients = [50.0, 120.0, -10.0]
range = [0.0, 2.0]
[laws."dahl.rho"]
kind = "constant"
value = 7000.0
[ranges]
displacement = [0.0, 0.015]
""")
damper = dp.models.Damper.load("own.toml")
print(damper)
again = dp.models.Damper.load(damper.save("own_saved.toml"))
for voltage in (0.0, 1.0, 2.0):
    force = damper.force(t, x, voltage=voltage)
    print(f"{voltage} V: {force.max():.1f} N, card gives the same: {np.array_equal(force, again.force(t, x, voltage=voltage))}")
