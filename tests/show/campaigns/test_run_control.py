"""What the progress of a campaign and its buttons show."""

from dampyr.campaigns.run_control import Progress, RunControl
from dampyr.show.descriptions import description_of


def test_progress_is_in_the_units_that_people_read() -> None:
    progress = Progress(2, 5, "03-sine", "steady", 0.256, 61.237, 1.5, 6.0, -123.456, 0.0123456, 23.4567)
    description = description_of(progress)
    assert description.title == "Progress, 2 of 5 tests"
    assert dict(description.rows) == {
        "test": "03-sine, steady, 25.6 %",
        "cycles": "1.5 of 6",
        "time left": "61.24 s",
        "now": "-123.5 N, 12.35 mm peak to peak, 23.46 °C",
    }


def test_the_pressed_buttons_are_named_until_they_are_released() -> None:
    control = RunControl()
    assert description_of(control).rows == [("pressed", "nothing")]
    control.pause()
    assert description_of(control).rows == [("pressed", "pause")]
    control.stop()
    assert description_of(control).rows == [("pressed", "pause, stop")]
    control.resume()
    assert description_of(control).rows == [("pressed", "stop")]
