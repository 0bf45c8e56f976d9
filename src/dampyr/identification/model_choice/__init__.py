"""Which model predicts the records best."""
