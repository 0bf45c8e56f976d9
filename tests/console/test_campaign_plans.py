"""Plans of campaigns as a page shows them: those of the command line, what is refused, notes, paths."""

import pytest

pytest.importorskip("fastapi")


SINE = '[[step]]\nkind = "sine"\namplitude = "4 mm"\nfrequency = "1 Hz"\n'


@pytest.mark.parametrize("key", ["rows", "motion"])
@pytest.mark.parametrize("path", ["/etc/passwd", "../../secret.csv"])
def test_a_campaign_reads_no_file_of_elsewhere(client, key, path):
    kind = "earthquake" if key == "motion" else "sine"
    answer = client.post("/api/campaigns/plan", json={"text": f'[[step]]\nkind = "{kind}"\n{key} = "{path}"\n'})
    assert answer.status_code == 400
    assert "is not a valid file name" in answer.json()["detail"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[step", "not valid TOML"),
        ("", "there is no step"),
        (SINE + "cycles = 1000000000\n", "shorten it"),
        ('[[step]]\nkind = "reversals"\nhalf_period = "60 s"\ncount = 1000000000\n', "shorten them"),
        (SINE + "repeats = 401\n", "at most 400"),
        (SINE.replace("4 mm", "4 kg"), "amplitude"),
        ("a = " + "[" * 5000, "not valid TOML"),
    ],
)
def test_a_campaign_that_cannot_be_is_one_sentence(client, text, words):
    answer = client.post("/api/campaigns/plan", json={"text": text})
    assert answer.status_code == 400, answer.text
    assert words in answer.json()["detail"]


def test_the_plan_is_that_of_the_command_line(client):
    from dampyr.campaigns import campaign_of, plan
    from dampyr.campaigns.force_prediction import specimen
    from dampyr.rig import RigSettings

    rig = RigSettings()
    expected = plan(
        campaign_of({"step": [{"kind": "sine", "amplitude": "9 mm", "frequency": "2 Hz"}]}), rig, specimen(rig)
    )
    reply = client.post(
        "/api/campaigns/plan", json={"text": SINE.replace("4 mm", "9 mm").replace("1 Hz", "2 Hz")}
    ).json()
    assert reply["refusals"] == list(expected.refusals)
    assert reply["tests"][0]["force_N"] == pytest.approx(expected.tests[0].peak_force)


def plan(client, text, **more):
    return client.post("/api/campaigns/plan", json={"text": text, "rig": "", **more})


def test_notes_on_tests_are_said_once_and_in_millimetres(client):
    text = '[[step]]\nkind = "sine"\namplitude = ["16 mm", "20 mm"]\nfrequency = ["0.1 Hz", "0.2 Hz"]\n'
    notes = plan(client, text).json()["notes"]
    assert notes == ["every test: displacement reaches 20 mm; the damper was calibrated up to 12 mm"]


def test_the_path_of_a_campaign_and_of_one_of_its_tests(client):
    text = 'rest_between = "5 s"\n[[step]]\nkind = "sine"\namplitude = ["2 mm", "3 mm"]\nfrequency = "1 Hz"\n'
    whole = client.post("/api/campaigns/path", json={"text": text, "rig": ""}).json()
    assert max(filter(None, whole["displacement"][1])) == pytest.approx(3.0, rel=1e-3)
    assert whole["voltage"][1].count(None) == 2
    assert [one["name"] for one in whole["tests"]] == ["01-sine-2mm-1Hz-0V", "02-sine-3mm-1Hz-0V"]
    one = client.post("/api/campaigns/path", json={"text": text, "rig": "", "test": "01-sine-2mm-1Hz-0V"}).json()
    assert max(filter(None, one["displacement"][1])) == pytest.approx(2.0, rel=1e-3)
    assert whole["duration_s"] == pytest.approx(2 * one["duration_s"] + 5.0)
