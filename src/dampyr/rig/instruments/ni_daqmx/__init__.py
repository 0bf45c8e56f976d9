"""A board of National Instruments, through NI-DAQmx."""

ROLE = "acquisition"
