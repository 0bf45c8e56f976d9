"""A fit, and what is to be said of it."""
