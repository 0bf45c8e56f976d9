"""The search of a fit: data, parameters, starting values, least squares, and the optimum where it ends."""
