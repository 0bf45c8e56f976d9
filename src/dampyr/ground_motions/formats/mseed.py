"""miniSEED: one channel, in the unit or with the factor of its counts that is declared; read with ObsPy, the extra
``seismology``."""

from __future__ import annotations

from pathlib import Path

from dampyr.errors import FileError, InputError, install_line, one_line
from dampyr.ground_motions.formats.sac import counted_motion
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.motion_options import MotionReadOptions

SUFFIXES = (".mseed", ".miniseed", ".msd")
TAKES_OPTIONS = True
TITLE = "miniSEED"


def read(
    path: Path, units: str | None = None, dt: float | None = None, options: MotionReadOptions | None = None
) -> GroundMotion:
    """The ground motion in a miniSEED file of one channel without a gap."""
    try:
        import obspy
    except ImportError as problem:
        raise InputError(f"miniSEED files need ObsPy; install it: {install_line('seismology')}") from problem
    try:
        stream = obspy.read(str(path), format="MSEED").merge()
    except Exception as problem:  # ObsPy raises whatever the broken bytes lead it to
        raise FileError(path, f"is not a readable miniSEED file ({one_line(problem)}); fetch it again") from problem
    if len(stream) != 1:
        names = ", ".join(trace.id for trace in stream) or "none"
        raise FileError(path, f"holds {len(stream)} channels ({names}); write each into a file of its own")
    [trace] = stream
    if trace.stats.npts != trace.data.size or getattr(trace.data, "mask", False) is not False:
        raise FileError(path, f"{trace.id} has a gap; cut out the part without it, or fetch the record again")
    if dt is not None and abs(dt - trace.stats.delta) > 1e-6 * trace.stats.delta:
        raise FileError(path, f"dt = {dt:g} s contradicts its step of {trace.stats.delta:g} s; leave dt out")
    source = f"miniSEED, {trace.id}, from {trace.stats.starttime}"
    return counted_motion(path, trace.data.astype(float), float(trace.stats.delta), units, options, source)
