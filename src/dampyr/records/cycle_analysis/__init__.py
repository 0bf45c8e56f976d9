"""Cycles of a record and what is measured of them."""
