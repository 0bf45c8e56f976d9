"""Many histories at once: the coupling step written out for one building, a block of histories side by side in a compiled loop.

`coordinates` chooses how the building's state is written, `text` writes the step, `arithmetic` has what it computes with,
`block` runs it over blocks of histories. `dampyr.structures.ensemble` is the way in.
"""
