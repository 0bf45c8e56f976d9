"""One file per kind of export, each with ``write(damper, folder, name, allow_extrapolation) -> list[Path]``."""
