"""Run the benches of this folder, or those named: ``python -m benchmarks [NAME ...]``."""

from __future__ import annotations

import sys
import time

from benchmarks._lines import data_folder, machine, show
from dampyr import registry


def main(wanted: list[str]) -> None:
    """Run the benches called ``wanted``; where none is named, all but those that want to be asked for."""
    start = time.perf_counter()
    print(machine())
    for name in wanted or usual():
        bench = registry.member("benchmarks", name)
        print(f"\n{bench.TITLE}")
        result = bench.run(data_folder())
        print(f"  left out: {result}" if isinstance(result, str) else show(result), flush=True)
    print(f"\n{time.perf_counter() - start:.0f} s in all")


def usual() -> list[str]:
    """Every bench but the long ones."""
    return [name for name, bench in registry.members("benchmarks") if not getattr(bench, "OPT_IN", False)]


if __name__ == "__main__":
    main(sys.argv[1:])
