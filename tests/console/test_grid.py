"""A grid of sines as the text of a campaign, and back."""

from dampyr.console.grid import Grid, grid_of, grid_text

SINE = '[[step]]\nkind = "sine"\namplitude = "4 mm"\nfrequency = "1 Hz"\n'


def test_a_grid_is_its_text_and_back():
    grid = Grid(
        'say "hi"\\',
        "me",
        "two\nlines \x07",
        [2.0, 0.1, 12.4],
        [0.5, 1.0],
        [0.0, 0.8712],
        cycles=7,
        repeats=2,
        random=True,
        seed=3,
    )
    assert grid_of(grid_text(grid)) == grid
    assert grid_of(SINE) == Grid(amplitude=[4.0], frequency=[1.0], voltage=[0.0])
    assert grid_of(SINE + SINE) is None
    assert grid_of(SINE.replace("sine", "sweep")) is None
    assert grid_of(SINE + "taper = 2\n") is None
    assert grid_of('rest_between = "1 s"\n' + SINE) is None
