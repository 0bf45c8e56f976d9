"""Reading of an uploaded file in a process with limits: ``python -m dampyr.console.limits``.

The content of a file is unknown until it is read, and a small file can unfold to a large one. So it is read where memory, time
and output are bounded, and saved as dampyr's own record file; the uploaded file is never opened anywhere else.
"""

from __future__ import annotations

import json
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

from dampyr.errors import DampyrError, FileError, InputError

MEMORY = 3 * 2**30  # bytes: 48 times the largest upload, since a small file can unfold to a large one
SECONDS = 60  # s: longer than a person waits for an upload
WRITTEN = 512 * 2**20  # bytes: eight times the largest upload
TOO_MUCH = "the file takes more time or memory to read than an upload may; read it with `dampyr records` instead"


def read_apart(path: Path, to: Path, said: dict[str, Any]) -> None:
    """Read the record in ``path`` in a process of its own and write it to ``to``, an .h5 file.

    ``said`` is what :func:`dampyr.records.read` takes besides. Raises InputError with what was wrong.
    """
    request = json.dumps({"path": str(path), "to": str(to), "said": said})
    command = [sys.executable, "-m", "dampyr.console.limits"]
    try:
        done = subprocess.run(command, input=request, capture_output=True, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(TOO_MUCH) from None
    if done.returncode == 2:
        raise InputError(json.loads(done.stdout)["reason"].replace(f"{path}", path.name))
    if done.returncode != 0 or not to.is_file():
        raise InputError(TOO_MUCH)


def bound() -> None:
    """Bound what this process may take, where the system can."""
    try:
        import resource
    except ImportError:  # Windows: the time alone is bounded, by who waits
        return
    for what, limit in (
        (resource.RLIMIT_AS, MEMORY),
        (resource.RLIMIT_CPU, SECONDS),
        (resource.RLIMIT_FSIZE, WRITTEN),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(what, (limit, limit))


def main() -> int:
    """Read and write what standard input asks for; 2 where the file is wrong, with the reason on standard output."""
    request = json.load(sys.stdin)
    bound()
    from dampyr import records

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            record = records.read(request["path"], **request["said"])
            records.describe(record)
            records.write(record, request["to"])
    except DampyrError as problem:
        if isinstance(problem, FileError) and problem.path == Path(request["to"]):
            return 1  # it came to more than may be written
        print(json.dumps({"reason": str(problem)}))
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
