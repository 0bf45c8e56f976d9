"""Steps that return a changed record, each told in its history, and what they are based on."""
