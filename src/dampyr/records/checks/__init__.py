"""What may be wrong with a record, and how well its channels are known."""
