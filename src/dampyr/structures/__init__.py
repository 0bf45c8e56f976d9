"""Buildings with dampers and their response to earthquakes.

``respond(building, motion, dampers={storey: damper}, voltage=...)`` integrates a building through a ground motion; a
damper stands in a storey or between any two floors, ``{(0, 2): damper}``, and one alone in storey 1. ``loads=`` are forces
on its floors, beside the motion or alone (`FloorLoads`, `read_loads`), and `SupportMotions` the motions of several supports
(`with_supports`, `half_car`, `read_supports`). ``two_storey()`` is the building of chapter 5, ``Building(M, C, K)``,
``shear_building``, ``torsional_building``, ``single_mass``, ``quarter_car`` and ``condense`` make others, ``load`` reads one
from a TOML file that ``save`` or an editor has written, ``state_space`` writes one as matrices. ``control_law`` makes a law
that sets an input in the place of a number, `Sensor` says what is wrong with what it measures, and `ControlLaw` and `LawDesign`
are for laws of one's own; a list of inputs gives `Responses`, a case for each.
``ensemble`` runs the outer product of buildings, dampers, inputs, motions and scales, and returns the peaks;
``fragility``, ``incremental`` and ``arena`` evaluate them, ``search_control`` chooses among inputs
and places, ``write_part`` and ``collect`` divide the work for a batch system.
"""

from dampyr.structures.benchmark_ratios import benchmark_criteria
from dampyr.structures.building import Building, condense
from dampyr.structures.building_options import EnsembleOptions, RespondOptions
from dampyr.structures.control_laws import available_control_laws, control_law, control_laws_of
from dampyr.structures.ensembles.arena import Arena, arena
from dampyr.structures.ensembles.control_search import ControlSearch, search_control
from dampyr.structures.ensembles.demand_tables import demand_tables, write_demands
from dampyr.structures.ensembles.ensemble import ensemble
from dampyr.structures.ensembles.ensemble_grid import cases as ensemble_cases
from dampyr.structures.ensembles.ensemble_result import EnsembleResult, read_ensemble
from dampyr.structures.ensembles.fragility import fragility
from dampyr.structures.ensembles.incremental import incremental
from dampyr.structures.ensembles.job_array import collect, write_part
from dampyr.structures.ensembles.summary import summary
from dampyr.structures.floor_loads import FloorLoads, read_loads
from dampyr.structures.isolation import isolated
from dampyr.structures.law_form import ControlLaw, LawDesign
from dampyr.structures.raminelli_2020_building import two_storey
from dampyr.structures.ride import RideFigures, ride_figures, vertical_weighting, weighted_acceleration
from dampyr.structures.road_profile import bump, random_road
from dampyr.structures.sensors import Sensor
from dampyr.structures.several_rides import Rides, rides
from dampyr.structures.shear import shear_building, single_mass
from dampyr.structures.structure_file import load, save
from dampyr.structures.support_records import read_supports
from dampyr.structures.supports import SupportMotions, with_supports
from dampyr.structures.time_history.respond import respond
from dampyr.structures.time_history.response import Response
from dampyr.structures.time_history.state_space import from_state_space, state_space
from dampyr.structures.torsion import torsional_building
from dampyr.structures.vehicle import axle_roads, half_car, quarter_car, road
from dampyr.structures.yielding import yielding_shear_building

__all__ = [
    "Building", "two_storey", "shear_building", "torsional_building", "yielding_shear_building", "isolated", "single_mass",
    "quarter_car", "half_car", "road", "axle_roads", "random_road", "bump", "ride_figures", "RideFigures",
    "vertical_weighting", "weighted_acceleration", "condense", "load", "save", "FloorLoads", "read_loads", "with_supports",
    "SupportMotions", "read_supports", "respond", "control_law", "arena", "Arena", "available_control_laws", "ControlLaw",
    "LawDesign",
    "Sensor", "search_control", "ControlSearch", "control_laws_of",
    "RespondOptions", "ensemble", "EnsembleOptions", "EnsembleResult", "ensemble_cases", "read_ensemble",
    "demand_tables", "write_demands", "summary", "fragility", "incremental", "write_part", "collect", "Response",
    "state_space", "from_state_space", "benchmark_criteria", "Rides", "rides",
]  # fmt: skip
