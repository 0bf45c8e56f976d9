"""Exact steps of the hysteresis equations, fast elementary functions, differentiation."""
