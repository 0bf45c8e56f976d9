"""A quarter car on a rough road

The body on its suspension over a road of class C, with the damper off and on.
"""

import dampyr as dp
from dampyr.show.figures.building import building_response
from dampyr.show.figures.style import ACCELERATION

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
car = S.quarter_car(sprung=290.0, unsprung=45.0, suspension=18e3, tyre=190e3, damping=300.0)
road = S.road(S.random_road("C", length=30.0, seed=1), spacing=0.05, speed=20.0)
rides = {f"{u:g} V": S.respond(car, road, {("unsprung", "sprung"): damper}, voltage=u) for u in (0.0, 2.0)}
building_response(road.time, {n: r.acceleration[1] for n, r in rides.items()}, ACCELERATION)
