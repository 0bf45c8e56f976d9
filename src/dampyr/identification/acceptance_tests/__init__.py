"""Whether a record lies within a band about a reference damper."""
