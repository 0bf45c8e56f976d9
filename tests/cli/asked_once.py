"""What a command computes is computed once where tests are of what is printed and written."""

import re
from collections.abc import Callable
from typing import Any


def asked_once(compute: Callable[..., Any], answers: dict[str, Any]) -> Callable[..., Any]:
    """``compute``, whose answers are kept by what was asked."""

    def once(*args: Any, **kwargs: Any) -> Any:
        asked = re.sub(r" at 0x\w+", "", repr((args, kwargs)))  # what shows progress is another one each time
        if asked not in answers:
            answers[asked] = compute(*args, **kwargs)
        return answers[asked]

    return once
