"""Settings of a rig whose board measures the coil's voltage and current."""

from __future__ import annotations

from dataclasses import replace

from dampyr.rig import RigSettings

RIG = replace(RigSettings(), wires=replace(RigSettings().wires, coil_voltage="ai2", coil_current="ai3"))
