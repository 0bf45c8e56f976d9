"""How well a damper predicts records, and within what band."""
