"""Published studies run again, the published value beside ours, and the demonstration of the whole chain."""
