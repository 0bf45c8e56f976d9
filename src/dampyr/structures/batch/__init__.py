"""Batch engine: the time step written out for one building, a block of histories at a time in a compiled loop.

`modal` chooses the coordinates of the building's state; `assemble` writes the step, with `building_step` and `damper_step` for
its two parts and `loop_fission` for its loops; `branchless_math` and `bouc_wen_branchless` have the functions that it calls;
`run_blocks` compiles the text, and `engine` (or `gpu`) runs it. `dampyr.structures.ensemble` is the public call, and
docs/explanations/generated-kernel.md shows one kernel.
"""
