"""Whether OpenSees is there, for all tests of it."""

import subprocess
import sys

import pytest
from tests.export.opensees_process import SCRIPT


@pytest.fixture(scope="session")
def opensees() -> None:
    """OpenSees, in processes of its own; a skip that says why it is not there."""
    code = f"import sys; sys.path.insert(0, {str(SCRIPT.parent)!r}); import opensees_model; opensees_model.opensees()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(
            f"OpenSees cannot be loaded ({done.stderr.splitlines()[-1]}); `make blas` installs Debian's libraries"
        )
