"""What results of `dampyr.planning` show: a file for each of its modules that define them."""
