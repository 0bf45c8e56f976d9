"""Pages of results, one file each, and what they are made of: sections, tables, figures and verdicts as one HTML file."""
