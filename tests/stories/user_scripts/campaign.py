"""Plan a campaign file, perform it on the simulated rig, and fit its records."""

import tempfile
from pathlib import Path

import dampyr as dp

folder = Path(tempfile.mkdtemp())
step = """
[[step]]
kind = "sine"
zip = true
amplitude = ["5 mm", "9 mm"]
frequency = ["1.2 Hz", "0.9 Hz"]
voltage = "{} V"
cycles = 3
rest_before = "0.5 s"
"""
head = 'name = "short"\noperator = "me"\nrest_between = "0.5 s"\ncheck_amplitude = "0 mm"\n'
(folder / "short.toml").write_text(head + step.format(0) + step.format(1.98))

plan = dp.campaigns.plan(folder / "short.toml")
print(len(plan.tests), "tests,", len(plan.refusals), "refused")
for test in plan.tests:
    print(f"{test.name:28} {test.duration:5.1f} s {1e3 * test.peak_speed:6.1f} mm/s")
with dp.rig.simulated(seed=1) as rig:
    recorded = dp.campaigns.perform(plan, rig, folder / "records")
tests, events = dp.campaigns.read_journal(recorded.folder)
print({test.state for test in tests})

records = dp.records.read_campaign(folder / "records")
fit = dp.identification.fit(records, "hyperbolic_tangent + spring")
print(fit)
for record in records:
    print(f"{record.name:28} L1 {dp.identification.score(fit.damper, record).l1:.1%}")
