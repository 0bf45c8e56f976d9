"""My three-storey shear building under El Centro, with and without a damper in storey 1: the peaks of both."""

import dampyr as dp

S = dp.structures
masses, springs = [400.0, 400.0, 300.0], [500e3, 450e3, 400e3]  # kg, N/m
building = S.shear_building(masses, springs, damping_ratio=0.02)
print("frequencies", building.frequencies.round(2), "Hz")

motion = dp.ground_motions.el_centro()
damper = dp.models.Damper("dahl", {"dahl.kx": 4000.0, "dahl.kw": 800.0, "dahl.rho": 5000.0})
bare = S.respond(building, motion)
damped = S.respond(building, motion, dampers={1: damper})
print("storey   drift bare / damped [mm]   acceleration bare / damped [m/s2]")
for k in range(3):
    print(
        f"{k + 1:6}   {1e3 * bare.peak_drift[k]:8.2f} / {1e3 * damped.peak_drift[k]:.2f}"
        f"   {bare.peak_acceleration[k]:16.2f} / {damped.peak_acceleration[k]:.2f}"
    )
print(f"largest damper force {abs(damped.force[0]).max():.0f} N, stroke {1e3 * abs(damped.stroke[0]).max():.2f} mm")
print("converged:", damped.converged, damped.scheme)
print(damped.to_dataframe())
