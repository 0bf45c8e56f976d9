"""What results of `dampyr.rig` show: a file for each of its modules that define them."""
