"""What a process of a request may take: its limits hold in the process, and what passes them is told in a sentence."""

import os
import subprocess
import sys

import pytest

from dampyr.console.limits import MIB, RequestLimits

LIMITS = RequestLimits(512 * MIB, 1.5, written=3 * MIB, repair="plan less")
WITHIN = """
import resource, sys
from dampyr.console.limits import MIB, RequestLimits
RequestLimits(512 * MIB, 1.5, written=3 * MIB).apply()
print(*(resource.getrlimit(getattr(resource, f"RLIMIT_{name}"))[1] for name in ("AS", "FSIZE", "CORE")))
try:
    bytearray(600 * MIB)
except MemoryError:
    print("too much")
"""


def test_what_passes_a_limit_is_told_with_the_limit_and_the_repair():
    assert LIMITS.too_long == "it takes more than the 1.5 s that a request may take; plan less"
    assert LIMITS.too_much == "it takes more memory than the 512 MiB that a request may take; plan less"


@pytest.mark.skipif(os.name != "posix", reason="Windows has no such limits")
def test_the_limits_hold_in_the_process_that_sets_them():
    done = subprocess.run([sys.executable, "-c", WITHIN], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == [f"{512 * MIB} {3 * MIB} 0", "too much"]
