"""Constants of the plant's kernel, from the settings and the specimen."""

from __future__ import annotations

from math import floor, pi

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.plant import Constants
from dampyr.rig.simulation.plant_specimen import delay_index, input_lag

DELAYED = 4096  # steps of force history for a specimen with a delay: 0.4 s at the default step


def constants_of(settings: RigSettings, specimen: Damper, dt: float) -> Constants:
    """The constants of a plant that is integrated with steps of ``dt`` s."""
    per_tick = round(1e-3 / dt)
    if per_tick < 1 or abs(per_tick * dt - 1e-3) > 1e-12:
        raise InputError(f"step = {dt:g} s is not allowed; a millisecond must be a whole number of steps")
    actuator, supply, damper = settings.actuator, settings.supply, settings.specimen
    low, high = specimen.range
    return Constants(
        dt=dt,
        per_tick=per_tick,
        free_speed=actuator.free_speed,
        droop=actuator.droop,
        lag=actuator.lag,
        dead_band=actuator.dead_band,
        stroke=0.5 * actuator.stroke,
        play=0.5 * actuator.backlash,
        friction=settings.table.friction,
        gain=supply.gain,
        cut=supply.enable_line,
        resistance=supply.resistance,
        inductance=supply.inductance,
        per_ampere=supply.resistance if specimen.input != "A" else 1.0,
        low=float(low),
        high=float(high),
        input_lag=input_lag(specimen),
        delay=delay_index(specimen, dt, DELAYED),
        heat_capacity=damper.heat_capacity,
        cooling=damper.cooling,
        softening=damper.softening,
        ambient_temperature=damper.room,
        pulse=settings.encoder.count,
        mark=floor(settings.encoder.index / settings.encoder.count),
        bandwidth=2.0 * pi * settings.load_cell.bandwidth,
        end=0.5 * (damper.stroke or settings.limits.stroke),
        switch=settings.table.end_switch,
        ends_wired=settings.wires.end_switches,
        emergency_wired=settings.wires.emergency_stop,
        clock_ppm=settings.uno.clock_ppm,
        clock_warming=settings.uno.clock_drift * settings.uno.warming,
        warming_time=settings.uno.warming_time,
        no_load_current=actuator.no_load_current,
        per_newton=(actuator.full_load_current - actuator.no_load_current) / actuator.max_load,
        step=settings.motor_current(1),
        mass=settings.load_cell.mass,
    )
