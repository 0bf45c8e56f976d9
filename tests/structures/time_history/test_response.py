"""A response as a dictionary, as a dataset, and in words."""

import json

from tests.structures.begin_of_el_centro import short

from dampyr.structures import respond, two_storey


def test_a_response_as_a_dictionary_goes_through_json(cubics):
    response = respond(two_storey(), short(1.0), cubics, voltage=1.0, step=0.005)
    read = json.loads(json.dumps(response.as_dict()))
    assert read["peak_displacement_m"] == response.peak_displacement.tolist()
    assert read["peak_force_N"] == response.peak_force.tolist()
    assert read["mean_input"] == [1.0]
    assert read["sites"] == ["storey 1"]
    assert read["step_s"] == 0.005
    assert read["error_estimate"] is None
    assert read["converged"] is True


def test_as_a_dataset(cubics):
    response = respond(two_storey(), short(1.0), {2: cubics}, voltage=0.0)
    data = response.to_xarray()
    assert data.displacement.dims == ("floor", "time")
    assert data.displacement.attrs["units"] == "m"
    assert data.time.attrs["units"] == "s"
    assert data.damper_storey.values.tolist() == [2]
    assert float(data.peak_drift.sel(storey=2)) == response.peak_drift[1]
    assert data.attrs["scheme"] == "exact path"
