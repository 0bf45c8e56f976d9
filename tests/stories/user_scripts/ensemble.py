"""How likely does a storey of my building drift beyond 12 mm: 20 motions, 10 scales, no damper, 0 V and 1.98 V?"""

import numpy as np

import dampyr as dp

S = dp.structures
building = S.shear_building([300.0, 250.0], [200e3, 150e3], damping_ratio=0.03)
damper = dp.studies.raminelli_2020.damper()
motions = [dp.ground_motions.kanai_tajimi(10.0, 0.01, seed=(11, k), pga=3.0) for k in range(1, 21)]
result = S.ensemble(
    building,
    motions,
    dampers=[None, damper],
    voltage=[0.0, 1.98],
    scales=np.geomspace(0.2, 3.0, 10),
    limits=["12mm"],
    out="peaks.h5",
)
print(result)
print(dict(result.dataset.sizes), f"error {result.dataset.attrs['error_estimate']:.1e}")
fragilities = S.fragility(result.dataset, "drift", limit=0.012, intensity="pga", draws=100, seed=1)
for curve in fragilities.curves:
    print(f"{curve.name:10} median {curve.theta:.2f} m/s2, beta {curve.beta:.2f}, at 3 m/s2: {curve.at(3.0):.0%}")
ratio, low, high = fragilities.ratio("1.98 V", "no damper")
print(f"1.98 V against no damper: {ratio:.2f} ({low:.2f} to {high:.2f})")
