"""Compare a semi-active control law with constant voltages in my two-storey building under El Centro."""

import dampyr as dp

S = dp.structures
building = S.shear_building([250.0, 200.0], [120e3, 90e3], damping_ratio=0.02)
motion, damper = dp.ground_motions.el_centro(), dp.studies.raminelli_2020.damper()
cases = {
    "0 V": 0.0,
    "3.212 V": 3.212,
    "on-off": S.control_law("on_off", high=3.212, lag=0.01),
    "clipped-optimal": S.control_law("clipped_optimal", high=3.212, lag=0.01, effort=0.05),
}
bare = S.respond(building, motion)
print(f"{'no damper':16} drifts {(1e3 * bare.peak_drift).round(1)} mm, {max(bare.peak_acceleration):.2f} m/s2")
responses = {}
for name, voltage in cases.items():
    r = responses[name] = S.respond(building, motion, {1: damper}, voltage=voltage, accuracy="fast")
    print(
        f"{name:16} drifts {(1e3 * r.peak_drift).round(1)} mm, {max(r.peak_acceleration):.2f} m/s2, "
        f"mean {r.mean_input[0]:.2f} V, converged {r.converged}"
    )
