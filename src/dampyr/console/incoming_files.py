"""Files that a browser sends: received into a folder of their own within the limits, before anything reads or keeps them."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from anyio import to_thread
from fastapi import HTTPException, Request

from dampyr.console import safe_paths
from dampyr.console.security import MAX_UPLOAD
from dampyr.errors import InputError

BODY = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}
"""What a request with a file says of its body."""


@asynccontextmanager
async def incoming(data: Path) -> AsyncIterator[Path]:
    """A folder for one file that comes in; gone afterwards."""
    folder = Path(tempfile.mkdtemp(prefix="incoming-", dir=data / safe_paths.OWN))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


async def receive(request: Request, path: Path, data: Path, quota: int, most: int = MAX_UPLOAD) -> None:
    """Write the body to ``path`` as it comes, within the limits: ``most`` bytes, and what the data folder may hold."""
    free_bytes = quota - await to_thread.run_sync(safe_paths.used, data)
    size = 0
    with path.open("wb") as file:
        async for piece in request.stream():
            size += len(piece)
            if size > most:
                raise HTTPException(413, f"too large; at most {most // 2**20} MiB are taken")
            if 2 * size > free_bytes:
                raise HTTPException(
                    413, "the data folder is full; delete what is not needed, or start with a larger --quota"
                )
            file.write(piece)
    if size == 0:
        raise InputError("the file is empty; choose another")
