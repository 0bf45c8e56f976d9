"""What the console offers is what the registries have."""

import io
import zipfile

import numpy as np
import pytest

pytest.importorskip("fastapi")

from dampyr import registry
from dampyr.models.part import part
from dampyr.records import Record, write
from dampyr.studies import raminelli_2020


def test_models_and_add_ons_are_all_parts(client):
    choices = client.get("/api/identify/choices").json()
    assert sorted([*choices["models"], *choices["add_ons"]]) == registry.names("dampyr.models.parts")
    assert all(part(name).add_on for name in choices["add_ons"])
    assert list(choices["exports"]) == registry.names("dampyr.export.kinds")


def test_motions_have_any_suffix_that_is_read(client, data):
    suffixes = [suffix for _, module in registry.members("dampyr.ground_motions.formats") for suffix in module.SUFFIXES]
    (data / "motions").mkdir()
    for suffix in (*suffixes, ".doc"):
        (data / "motions" / f"one{suffix}").write_text("0.01 g\n")
    assert client.get("/api/building/choices").json()["motions"] == sorted(f"one{suffix}" for suffix in suffixes)


@pytest.mark.prove
def test_every_kind_of_step_is_offered_with_a_table_that_can_be_planned(client):
    kinds = client.get("/api/campaigns/kinds").json()
    assert [one["name"] for one in kinds] == registry.names("dampyr.campaigns.steps")
    for one in kinds:
        answer = client.post("/api/campaigns/plan", json={"text": one["text"]})
        assert answer.status_code == 200, answer.text
        assert answer.json()["refusals"] == []
        assert len(answer.json()["tests"]) == 1


@pytest.mark.prove
def test_an_identified_damper_is_exported_as_every_kind(client, data, finished):
    t = np.linspace(0.0, 6.0, 1200)
    x, v = 0.008 * np.sin(6.0 * t), 0.048 * np.cos(6.0 * t)
    force = raminelli_2020.damper().force(t, x, velocity=v, voltage=1.0)
    write(Record(t, x, force, velocity=v, voltage=1.0), data / "one.csv")
    job = finished(client.post("/api/identify/jobs", json={"records": ["data/one.csv"], "model": "dahl"}).json()["id"])
    place = f"/api/identify/jobs/{job['id']}/export"
    for kind in registry.names("dampyr.export.kinds"):
        answer = client.get(place, params={"to": kind})
        assert answer.headers["content-disposition"] == f'attachment; filename="damper-{kind}.zip"'
        assert zipfile.ZipFile(io.BytesIO(answer.content)).namelist()
    assert sorted(zipfile.ZipFile(io.BytesIO(client.get(place, params={"to": "c"}).content)).namelist()) == [
        "Makefile",
        "damper.c",
        "damper.h",
        "damper_test.c",
        "damper_vectors.h",
    ]
    refused = client.get(place, params={"to": "fortran"})
    assert refused.status_code == 400
    assert "choose from" in refused.json()["detail"]
