"""Read another laboratory's text file (semicolons, decimal commas, German names, mm and kN) as a record."""

from pathlib import Path

import numpy as np

import dampyr as dp

rng = np.random.default_rng(3)
t = np.arange(0.0, 6.0, 0.005)
x = 8.0 * np.sin(2 * np.pi * 1.0 * t)  # mm
force = dp.studies.raminelli_2020.damper().force(t, x / 1e3, voltage=1.98) / 1e3  # kN
lines = ["Prüfstand 4, Dämpfer Nr. 12", "Datum: 12.03.2026", "Zeit [s];Kolbenweg [mm];Kraft [kN];Spule [V]"]
for row in zip(t, x, force, 1.98 + rng.normal(0.0, 0.01, t.size)):
    lines.append(";".join(f"{value:.5f}" for value in row).replace(".", ","))
Path("pruefung.txt").write_text("\n".join(lines), encoding="latin-1")

columns = {"time": "Zeit", "displacement": "Kolbenweg", "force": "Kraft", "voltage": "Spule"}
record = dp.records.read("pruefung.txt", columns=columns, specimen="no. 12")
[record] = dp.records.nominal_inputs([record])
print(record)
seen = dp.records.measure(record)
print(f"{seen.frequency_hz:.3f} Hz, {1e3 * seen.peak_to_peak_m:.2f} mm, {record.input_value} {record.input}")
print(f"force from {record.force.min():.0f} to {record.force.max():.0f} N")
for line in record.history:
    print("-", line)
