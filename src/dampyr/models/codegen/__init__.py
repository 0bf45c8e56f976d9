"""Code generation: the formulas of a damper's parts as data, written out as Python functions that numba compiles.

``formula`` reads and differentiates one formula, ``layout`` says where states and parameters are, ``parallel``, ``series``
and ``batched_path`` write the functions of the whole damper, ``composition`` puts them together, ``kernels`` compiles them.
The export to C reads the same functions.
"""
