"""The README as an index page shows it: links to files of the repository become addresses, where the project has one."""

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LINK = re.compile(r"(!?\[[^]]*\])\((?!https?://|#)([^)\s]+)\)")


def absolute(text: str, repository: str) -> str:
    """The text with relative links below ``repository``, pictures as their raw files; as it is without an address."""
    if not repository:
        return text

    def replace(found: re.Match[str]) -> str:
        kind = "raw" if found[1].startswith("!") else "blob"
        return f"{found[1]}({repository.rstrip('/')}/{kind}/main/{found[2]})"

    return LINK.sub(replace, text)


class CustomMetadataHook(MetadataHookInterface):
    """Sets ``readme``, which pyproject.toml declares as dynamic."""

    def update(self, metadata: dict[str, Any]) -> None:
        text = (Path(self.root) / "README.md").read_text("utf-8")
        repository = metadata.get("urls", {}).get("Repository", "")
        metadata["readme"] = {"content-type": "text/markdown", "text": absolute(text, repository)}
