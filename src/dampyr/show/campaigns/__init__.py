"""What results of `dampyr.campaigns` show: a file for each of its modules that define them."""
