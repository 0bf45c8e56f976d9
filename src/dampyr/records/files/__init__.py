"""Files and folders of records, read and written, whatever the format of a file."""
