"""Many responses: peaks over buildings, dampers, inputs, motions and scales, and what is made of them."""
