"""From formulas to kernels: the functions of a damper's parts as data, written out as Python, for many samples at once
and as C.
"""
