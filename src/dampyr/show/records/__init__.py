"""What results of `dampyr.records` show: a file for each of its modules that define them."""
