"""Read my sine tests at two voltages (time in s, displacement in mm, force in N) and fit one Dahl model to them."""

import csv

import numpy as np

import dampyr as dp
from dampyr.units import for_people

rng = np.random.default_rng(1)
made_of = {0.0: {"dahl.kx": 900.0, "dahl.kw": 60.0, "dahl.rho": 9000.0}, 2.0: {"dahl.kx": 3000.0, "dahl.kw": 240.0, "dahl.rho": 6000.0}}
t = np.arange(0.0, 8.0, 0.005)
files = []
for voltage, numbers in made_of.items():
    for amplitude, frequency in ((4, 1.4), (8, 1.0), (12, 0.6)):  # mm, Hz
        x = amplitude * np.sin(2 * np.pi * frequency * t)
        force = 30.0 + dp.models.Damper("dahl", numbers).force(t, x / 1e3) + rng.normal(0.0, 2.0, t.size)
        name = f"sine_{amplitude}mm_{voltage:g}V.csv"
        with open(name, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["time", "displacement", "force"])
            writer.writerows(zip(t.round(4), x.round(5), force.round(3)))
        files.append((name, voltage))

units = {"time": "s", "displacement": "mm", "force": "N"}
records = [dp.records.read(name, units=units, voltage=voltage) for name, voltage in files]
fit = dp.identification.fit(records, "dahl")
intervals = fit.intervals()
print(f"{len(records)} records, converged: {fit.converged}")
for name, value in fit.parameters.items():
    unit, factor = for_people(fit.units[name])
    low, high = intervals[name]
    print(f"{name:15} {value * factor:8.2f}  ({low * factor:.2f} to {high * factor:.2f}) {unit}")
print(f"offset {fit.nuisances['sine_8mm_2V'].offset:.1f} N")
fit.damper.save("mine.toml")
