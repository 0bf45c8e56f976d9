"""What results of `dampyr.models` show: a file for each of its modules that define them."""
