"""A damper fitted to ten records predicts one that it never saw, beside the published damper.

Needs the campaign's files (``dampyr datasets fetch labcontrol``). It prints::

    ensaio.vali.1      L1   peak force  energy
    fitted          8.8 %     +9.0 %   +6.0 %
    published       7.6 %     +0.3 %   +2.4 %
"""

import dampyr as dp
from dampyr.studies import raminelli_2020

folder = dp.records.locate("labcontrol")
[unseen] = dp.records.read_campaign(folder, role="validation")
alike = [r for r in dp.records.read_campaign(folder) if r.voltage == unseen.voltage]
fit = dp.identification.fit(alike, "dahl + spring")

print(f"{unseen.name}      L1   peak force  energy")
for name, damper in (("fitted", fit.damper), ("published", raminelli_2020.damper())):
    score = dp.identification.score(damper, unseen)
    print(f"{name:14} {100 * score.l1:4.1f} % {100 * score.peak_force:+8.1f} % {100 * score.energy:+6.1f} %")
