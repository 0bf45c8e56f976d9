"""What results of `dampyr.identification` show: a file for each of its modules that define them."""
