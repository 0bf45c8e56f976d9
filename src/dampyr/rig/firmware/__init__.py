"""What runs on the Uno: the protocol that it speaks, and a model of it."""
