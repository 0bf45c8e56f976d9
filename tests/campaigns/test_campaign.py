"""Reading campaigns: grids, rows, names, order, and mistakes told with their place."""

from pathlib import Path

import pytest

from dampyr import campaigns
from dampyr.errors import FileError, MissingData

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SINE = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz"}


def read(*steps, **header):
    return campaigns.campaign_of({"step": list(steps), **header})


def names(campaign):
    return [test.name for test in campaign.tests]


def test_quantities_become_si():
    [test] = read(SINE | {"voltage": "871.2 mV", "centre": -0.003, "rest_before": "1500 ms"}).tests
    assert (test.step.amplitude, test.step.voltage, test.step.centre) == (0.008, 0.8712, -0.003)
    assert test.step.rest_before == 1.5


def test_peak_to_peak_is_twice_the_amplitude():
    settings = {"kind": "sine", "peak_to_peak": ["24.75 mm", "10 mm"], "frequency": "1 Hz"}
    assert [t.step.amplitude for t in read(settings).tests] == [0.012375, 0.005]


def test_repeats_keep_the_number_and_the_drive():
    campaign = read(SINE, SINE | {"voltage": "1.98 V", "repeats": 2})
    assert names(campaign) == ["01-sine-8mm-1Hz-0V", "02-sine-8mm-1Hz-1.98V-r1", "02-sine-8mm-1Hz-1.98V-r2"]
    planned = campaigns.plan(campaign).tests
    assert planned[1].drive is planned[2].drive


def test_the_order_is_drawn_by_the_seed_and_the_names_are_not():
    steps = [{"kind": "warm_up"} | {k: v for k, v in SINE.items() if k != "kind"}, SINE | {"voltage": [0, 1, 2, 3]}]
    steps += [{"kind": "rest", "duration": 5}, SINE | {"voltage": [0.5, 1.5, 2.5], "repeats": 2}]
    written = names(read(*steps))
    one, again, other = (names(read(*steps, order="random", seed=k)) for k in (1, 1, 2))
    assert one == again != other
    assert sorted(one) == sorted(written) != one
    assert one[0] == written[0]
    assert one[5] == written[5]  # the rest keeps its place, and what stands on either side of it stays there
    assert sorted(one[1:5]) == sorted(written[1:5])


def test_a_seed_may_be_given_in_place_of_the_files():
    path = EXAMPLES / "every_kind.toml"
    assert names(campaigns.read(path)) == names(campaigns.read(path, seed=3)) != names(campaigns.read(path, seed=4))


def test_names_are_unique_and_fit_for_files():
    for path in EXAMPLES.glob("*.toml"):
        campaign_names = names(campaigns.read(path))
        assert len(set(campaign_names)) == len(campaign_names)
        assert not [
            name
            for name in campaign_names
            if set(name) - set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+.")
        ]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('name = "a"', r"there is no step; give at least one table \[\[step\]\]"),
        ("[[step]]\namplitude = 1", "step 1.kind is missing"),
        ('[[step]]\nkind = "sinus"', "step 1.kind: 'sinus' is not among the kinds of step; did you mean 'sine'"),
        ('[[step]]\nkind = "sine"\namplitude = "8 mm"', "step 1.frequency is missing"),
        ('[[step]]\nkind = "rest"\nduration = 5\n[[step]]\nkind = "rest"\nlength = 5', "step 2.length is not known"),
        ('[[step]]\nkind = "sine"\namplitude = "8 V"\nfrequency = 1', "step 1.amplitude = '8 V': the unit 'V'"),
        ('[[step]]\nkind = "sine"\namplitude = "-8 mm"\nfrequency = 1', "step 1.amplitude = -0.008 m is not allowed"),
        ('[[step]]\nkind = "sine"\namplitude = 1\nfrequency = 1\ncycles = 1.5', "step 1.cycles = 1.5 must be a whole"),
        ('[[step]]\nkind = "sine"\namplitude = 1\nfrequency = 1\ncycles = 0', "step 1.cycles = 0 is not allowed"),
        ('[[step]]\nkind = "sine"\namplitude = 1\npeak_to_peak = 1\nfrequency = 1', "give one of the two"),
        ('[[step]]\nkind = "sine"\namplitude = []\nfrequency = 1', "step 1.amplitude = .* is empty"),
        (
            '[[step]]\nkind = "sine"\namplitude = [1, 2]\nfrequency = [1]\nzip = true',
            "amplitude has 2, frequency has 1",
        ),
        ('[[step]]\nkind = "sine"\namplitude = 1\nfrequency = 1\nzip = true', "there is no list"),
        ('[[step]]\nkind = "rest"\nduration = 1\nrepeats = 0', "step 1.repeats = 0"),
        ('[[step]]\nkind = "rest"\nduration = 1\nrepeats = 9000', "9,000 tests; split it"),
        ('order = "shuffled"\n[[step]]\nkind = "rest"\nduration = 1', "order = 'shuffled' is not known"),
        ('seed = -1\n[[step]]\nkind = "rest"\nduration = 1', "seed = -1"),
        (
            'rest_betwen = "5 s"\n[[step]]\nkind = "rest"\nduration = 1',
            "rest_betwen is not known; did you mean 'rest_between'",
        ),
        ('[[steps]]\nkind = "rest"\nduration = 1', "steps is not known; did you mean 'step'"),
        ("[[step]\n", "is not valid TOML"),
        ("a." * 30_000 + "a = 1", "line 1 has a key of more than 32 parts"),
        (f"seed = {'9' * 60_000}", "a number in it has thousands of digits"),
        ("x = " + "[" * 30_000, "nest too deeply"),
        (
            f'[[step]]\nkind = "sine"\namplitude = {[0.001] * 100}\nfrequency = {[1] * 100}\nvoltage = {[0] * 100}',
            "1,000,000 tests .step 1: 100 values of amplitude x 100 values of frequency x 100 values of voltage",
        ),
        (f'[[step]]\nkind = "rest"\nduration = 1\nrepeats = 1{"0" * 4000}', r"more than 10\^15 tests"),
    ],
)
def test_a_mistake_is_one_sentence_with_its_place(tmp_path, text, words):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(FileError, match=words) as raised:
        campaigns.read(path)
    assert str(raised.value).startswith(f"{path}: ")
    assert "\n" not in str(raised.value)


def test_files_that_are_not_there_are_named(tmp_path):
    with pytest.raises(MissingData, match=r"nowhere\.toml"):
        campaigns.read(tmp_path / "nowhere.toml")
    (tmp_path / "c.toml").write_text('[[step]]\nkind = "sine"\nrows = "rows.csv"\n')
    with pytest.raises(MissingData, match=r"rows\.csv"):
        campaigns.read(tmp_path / "c.toml")
    (tmp_path / "rows.csv").write_text("amplitude [mm],frequency\n8\n")
    with pytest.raises(FileError, match="line 2 has 1 cells, the header 2"):
        campaigns.read(tmp_path / "c.toml")
    (tmp_path / "rows.csv").write_text("amplitude [mm]\n")
    with pytest.raises(FileError, match="has no rows"):
        campaigns.read(tmp_path / "c.toml")


def test_an_earthquake_is_looked_for_beside_the_campaign(tmp_path):
    settings = {"kind": "earthquake", "motion": "quake.csv"}
    [test] = campaigns.campaign_of({"step": [settings]}, tmp_path).tests
    assert test.step.motion == str(tmp_path / "quake.csv")
    assert test.name == "01-earthquake-quake-scale1-0V"
