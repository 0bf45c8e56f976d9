"""Coroutines run to their end beside a loop that a browser of an earlier test has left running."""

import asyncio
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any


def result_of(work: Coroutine[Any, Any, Any]) -> Any:
    """What a coroutine gives, in a thread of its own."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, work).result()
