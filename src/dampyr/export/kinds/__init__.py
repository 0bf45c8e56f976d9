"""One file per kind of export, each with ``write(damper, folder, name, allow_extrapolation, *, ...) -> list[Path]``.

What stands after the star are the options of the kind, by keyword.
"""
