"""Ten scripts as users write them, from README and docs alone and without a look at the source, run as they were written.

They are what somebody wrote at the first try; a call that they need is part of the public face, and a change that breaks one of
them breaks such a user's script.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parent / "user_scripts"
RESULTS = {  # words of what each prints
    "acceptance": "weak",
    "campaign": "L1",
    "controlled_building": "clipped-optimal",
    "ensemble": "median",
    "export": "uniaxialMaterial BoucWen",
    "fit": "kx",
    "foreign_file": "Record",
    "own_building": "drift",
    "own_damper": "N",
    "plot": "fit.png",
}


def test_every_script_is_run() -> None:
    assert sorted(path.stem for path in SCRIPTS.glob("*.py")) == sorted(RESULTS)


@pytest.mark.prove
@pytest.mark.parametrize("name", sorted(RESULTS))
def test_a_script_runs_as_it_was_written(name: str, tmp_path: Path) -> None:
    environment = os.environ | {"MPLBACKEND": "Agg", "PYTHONWARNINGS": "default"}
    command = [sys.executable, str(SCRIPTS / f"{name}.py")]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert RESULTS[name] in done.stdout
