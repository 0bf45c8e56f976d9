"""Write the archive of kernels that goes into a wheel: for the Python that runs this, and this kind of machine.

The usual work of `dampyr.kernel_warming` is compiled in a folder without kernels, which takes about two minutes, and what
numba's front end has written of each kernel is kept. ``make kernels`` does it with the Python of ``.venv``; for another one run
this file with an environment of that Python in which dampyr is installed as in a checkout (``pip install -e .``), then build
the wheel.
"""

from __future__ import annotations

import os
import tempfile
import time

from dampyr.kernel_warming import warm_kernels
from dampyr.models.codegen.shipped_kernels import archive_path, collected_kernels, write_archive


def main() -> None:
    start = time.perf_counter()
    archive_path().unlink(missing_ok=True)
    with tempfile.TemporaryDirectory() as folder, collected_kernels() as kernels:
        os.environ["DAMPYR_CACHE"] = folder
        warm_kernels(lambda name, done: None if done else print(f"  {name}", flush=True))
    path = write_archive(kernels)
    size = path.stat().st_size / 2**20
    print(f"{path}: {len(kernels)} kernels, {size:.1f} MiB, in {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
