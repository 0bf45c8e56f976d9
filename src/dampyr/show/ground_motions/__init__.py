"""What results of `dampyr.ground_motions` show: a file for each of its modules that define them."""
