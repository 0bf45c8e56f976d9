"""The model of `opensees_model` in processes of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

import dampyr as dp
from dampyr.ground_motions import GroundMotion

SCRIPT = Path(__file__).with_name("opensees_model.py")
FIRST_FLOOR = 27.208  # mm, at 0 V


def model(step: float, motion: GroundMotion | None = None, **request: Any) -> dict[str, Any]:
    """What the model of `opensees_model` answers, in a process of its own; under El Centro, or another motion."""
    building, motion = dp.structures.two_storey(), motion or dp.ground_motions.el_centro()
    K, C = building.K, building.C
    request |= {
        "masses": np.diag(building.M).tolist(),
        "pairs": [
            [float(a), float(c)] for a, c in ((K[0].sum(), C[0].sum()), (-K[0, 1], -C[0, 1]), (K[1].sum(), C[1].sum()))
        ],
        "dt": motion.dt,
        "acceleration": motion.acceleration.tolist(),
        "step": step,
    }
    done = subprocess.run(
        [sys.executable, str(SCRIPT)],
        input=json.dumps(request),
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    assert answer["failed"] == 0
    print(request.get("port", "text"), step, {k: v for k, v in answer.items() if k != "failed"})
    return answer
