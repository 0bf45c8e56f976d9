"""What the plastic-region method shows, in the units that people read."""

from dampyr.identification.limit_cycle_methods.plastic_region import PlasticRegion
from dampyr.show.descriptions import description_of


def test_the_parameters_are_per_mm() -> None:
    region = PlasticRegion(1234.5, 380.5, 42745.0, 2500.0, 12.25, 1500.0, 0.4321, 17)
    assert dict(description_of(region).rows) == {
        "kx": "1.234 N s/mm",
        "kw": "380.5 N",
        "rho": "42.74 1/mm, standard deviation 1.5 1/mm",
        "a": "2.5 N/mm",
        "offset": "12.25 N",
        "used": "43.2 % of the samples, 17 turning points",
    }
