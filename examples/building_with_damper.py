"""The two-storey building under half of El Centro 1940, with the published damper in either storey or in both.

It needs no data. It prints::

    no damper      first floor 22.77 mm, roof 34.52 mm, dampers took   0 % of the energy
    first storey   first floor  4.72 mm, roof  8.89 mm, dampers took  75 % of the energy
    second storey  first floor 13.57 mm, roof 17.40 mm, dampers took  42 % of the energy
    both           first floor  3.23 mm, roof  3.44 mm, dampers took  98 % of the energy
"""

import dampyr as dp
from dampyr.studies import raminelli_2020

damper = raminelli_2020.damper()
building, motion = dp.structures.two_storey(), dp.ground_motions.el_centro().scaled(0.5)
cases = {
    "no damper": {},
    "first storey": {1: damper},
    "second storey": {2: damper},
    "both": {1: damper, 2: damper},
}
for name, dampers in cases.items():
    response = dp.structures.respond(building, motion, dampers, voltage=0.8712)
    first, roof = 1e3 * response.peak_displacement
    taken = 100 * response.energy.damper[-1] / response.energy.input[-1]
    print(f"{name:14} first floor {first:5.2f} mm, roof {roof:5.2f} mm, dampers took {taken:3.0f} % of the energy")
