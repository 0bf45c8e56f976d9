"""What results of `dampyr.structures` show: a file for each of its modules that define them."""
