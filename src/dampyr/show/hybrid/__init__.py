"""What results of `dampyr.hybrid` show: a file for each of its modules that define them."""
