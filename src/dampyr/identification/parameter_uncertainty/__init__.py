"""How well the parameters of a fit are known, and how the dampers of one type differ."""
