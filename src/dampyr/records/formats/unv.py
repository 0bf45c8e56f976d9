"""Universal files of SDRC I-DEAS and Siemens: as ``.uff``."""

from dampyr.records.formats.uff import TITLE, read

__all__ = ["TITLE", "read"]
