"""One Dahl damper for the whole published campaign, with how well each number is known.

Needs the campaign's files (``dampyr datasets fetch labcontrol``). Writes the card dahl.toml. It prints::

    38 records, converged: True
    dahl.kx @ 0 V         0.85 +- 0.02 N s/mm
    dahl.kx @ 0.8712 V    2.12 +- 0.08 N s/mm
    dahl.kx @ 1.98 V      6.17 +- 0.41 N s/mm
    dahl.kx @ 3.212 V    12.71 +- 0.90 N s/mm
    dahl.kw @ 0 V        53.94 +- 1.28 N
    dahl.kw @ 0.8712 V  175.94 +- 3.54 N
    dahl.kw @ 1.98 V    251.57 +- 8.69 N
    dahl.kw @ 3.212 V   326.84 +- 13.17 N
    dahl.rho @ 0 V       31.04 +- 1.67 1/mm
    dahl.rho @ 0.8712 V  25.48 +- 0.51 1/mm
    dahl.rho @ 1.98 V    17.01 +- 0.21 1/mm
    dahl.rho @ 3.212 V    9.66 +- 0.16 1/mm
"""

import dampyr as dp
from dampyr.units import for_people

records = dp.records.read_campaign(dp.records.locate("labcontrol"))
fit = dp.identification.fit(records, "dahl")
print(f"{len(records)} records, converged: {fit.converged}")
for name, value in fit.parameters.items():
    unit, factor = for_people(fit.units[name])
    print(f"{name:19} {value * factor:6.2f} +- {fit.stderr[name] * factor:.2f} {unit}")
fit.damper.save("dahl.toml")
