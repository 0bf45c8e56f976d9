"""The figures, one file each: plain arrays in SI come in, a matplotlib ``Figure`` goes out."""
