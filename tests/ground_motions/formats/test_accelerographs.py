"""Files of networks of accelerographs: each layout with its traps, recognised by content, in its unit, checked by its peak."""

import numpy as np
import pytest
from tests.ground_motions import accelerograph_files as files
from tests.ground_motions.accelerograph_files import shaking

from dampyr.errors import FileError
from dampyr.ground_motions import read, read_components

G, EXACT = 9.80665, 1e-6


def near(motion, expected):
    return np.abs(motion.acceleration - expected).max() <= EXACT * np.abs(expected).max()


def of_knet(path):
    """An offset 20 times the shaking, which the header's peak does not have in it."""
    counts = np.round(shaking(201, peak=6e4)) + 1_200_000
    gal = 3920 / 6182761 * (counts - counts.mean())
    return files.knet(path, counts, np.abs(gal).max()), {"E-W": 0.01 * gal}, 0.01


def of_esm(path):
    return files.esm(path, shaking()), {"HNE": 0.01 * shaking()}, 0.005


def of_smc(path):
    return files.smc(path, shaking()), {"133": 0.01 * shaking()}, 0.005


THREE = {"1: 360 Deg": shaking(41, 1, 250.0), "2: 90 Deg": shaking(41, 2, 990.0), "3: Up": shaking(41, 3, 80.0)}
NAMED = {name.partition(": ")[2]: values for name, values in THREE.items()}


def of_cosmos(path):
    return files.cosmos(path, NAMED), {name: 0.01 * values for name, values in THREE.items()}, 0.005


def of_csmip_v2(path):
    """A step of a 300th of a second, which its line prints as .003."""
    return files.csmip_v2(path, NAMED, 0.0033333), {name: 0.01 * values for name, values in THREE.items()}, 0.0033333


def of_csmip_v1(path):
    values = 1e-3 * shaking(peak=79.18)
    return files.csmip_v1(path, values), {"1: 360 Deg": G * values}, 0.005


def of_volume_1(path):
    """A value of -1 g, whose field touches the time before it, in two components."""
    time, values = 0.02 * np.arange(33), np.round(shaking(33, peak=10.0), 3)
    channels = {"90 DEG": (time, values), "UP": (time, 0.5 * np.round(values))}
    return files.volume_1(path, channels), {"1: 90 DEG": 0.1 * G * values, "2: UP": 0.05 * G * np.round(values)}, 0.02


def of_geonet_v1(path):
    channels = {name: np.round(values, 1) for name, values in {"N28W": shaking(peak=12000.0), "Up": shaking()}.items()}
    return files.geonet(path, channels, 1), {name: 1e-3 * values for name, values in channels.items()}, 0.02


def of_geonet_v2(path):
    channels = {name: np.round(values, 1) for name, values in {"N28W": shaking(peak=12000.0), "Up": shaking()}.items()}
    return files.geonet(path, channels, 2), {name: 1e-3 * values for name, values in channels.items()}, 0.02


def of_afad(path):
    channels = {"N-S": shaking(seed=1), "E-W": shaking(seed=2), "U-D": shaking(seed=3)}
    return files.afad(path, channels), {name: 0.01 * values for name, values in channels.items()}, 0.01


LAYOUTS = [
    of_knet, of_esm, of_smc, of_cosmos, of_csmip_v2, of_csmip_v1, of_volume_1, of_geonet_v1, of_geonet_v2, of_afad,
]  # fmt: skip


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_component_is_read_exactly_by_content(tmp_path, layout):
    path, expected, dt = layout(tmp_path / "record.dat")  # a suffix that says nothing
    motions = read_components(path)
    assert list(motions) == list(expected)
    for name, motion in motions.items():
        assert near(motion, expected[name])
        assert motion.dt == pytest.approx(dt, rel=1e-9)
        assert motion.name == f"record {name}"
    name = list(expected)[-1]
    assert near(read(path, component=name), expected[name])
    assert near(read(path, component=name.split()[-1].lower()), expected[name])


@pytest.mark.parametrize("share", [0.4, 0.97])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_file_that_was_cut_is_refused(tmp_path, layout, share):
    path, _, _ = layout(tmp_path / "record.dat")
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(FileError, match=r"record\.dat: "):
        read_components(path)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_files_unit_and_step_are_not_declared_anew(tmp_path, layout):
    path, expected, dt = layout(tmp_path / "record.dat")
    name = next(iter(expected))
    with pytest.raises(FileError, match=r"units = 'ft/s\^2' contradict the file's"):
        read(path, units="ft/s^2", component=name)
    with pytest.raises(FileError, match=r"dt = 0\.5 s contradicts"):
        read(path, dt=0.5, component=name)
    assert read(path, dt=dt, component=name).dt == pytest.approx(dt)


def test_one_of_several_components_is_chosen_by_its_name(tmp_path):
    path, expected, _ = of_csmip_v2(tmp_path / "record.v2")
    with pytest.raises(
        FileError, match=r"holds 3 components \(1: 360 Deg, 2: 90 Deg, 3: Up\); choose one, such as --component"
    ):
        read(path)
    assert near(read(path, component="90"), expected["2: 90 Deg"])
    with pytest.raises(FileError, match="component = 'deg' fits 2 of the components; choose from 1: 360 Deg"):
        read(path, component="deg")
    with pytest.raises(FileError, match="component = 'N-S' is not a component of the file"):
        read(path, component="N-S")


def test_a_peak_that_the_header_does_not_name_is_refused_and_its_rounding_is_not(tmp_path):
    values = shaking()
    assert read(files.esm(tmp_path / "a.asc", values, peak=100.4)).pga == pytest.approx(1.0)
    with pytest.raises(FileError, match=r"the samples peak at 100 cm/s\^2 and the header says 101 cm/s\^2"):
        read(files.esm(tmp_path / "b.asc", values, peak=101.0))
    small = 1e-3 * shaking(peak=12.3)  # 0.012 in the header, 2.5 % less
    assert read(files.csmip_v1(tmp_path / "c.v1", small)).pga == pytest.approx(0.0123 * G)


def test_the_mean_of_k_net_is_told(tmp_path):
    path, _, _ = of_knet(tmp_path / "XXX0010102030405.EW")
    motion = read(path)
    assert motion.history == (
        f"mean of {1_200_000 + shaking(201, peak=6e4).round().mean():.6g} counts (760.1 gal) taken off",
    )
    assert "from 2001/02/03 04:05:21 JST less 15 s" in motion.source
    assert list(read_components(files.knet(tmp_path / "a.UD2", np.round(shaking(201, peak=6e4)), 38.22, "6"))) == [
        "U-D surface"
    ]


def test_uneven_times_are_set_on_their_own_grid_and_told(tmp_path):
    """The straight lines between the samples of the file are kept."""
    time = np.cumsum([0.0, 0.019, 0.021, 0.02, 0.004, 0.036, 0.02, 0.013])
    values = np.array([0.0, 1.25, -2.5, 9.999, 0.4, -0.1, 3.0, 0.0])
    motion = read(files.volume_1(tmp_path / "usc.s0a", {"N08W": (time, values)}, blank=" "))
    assert motion.dt == 0.001
    np.testing.assert_allclose(motion.acceleration, 0.1 * G * np.interp(motion.time, time, values), atol=1e-12)
    assert motion.pga == pytest.approx(0.9999 * G)
    assert motion.history[0].startswith("uneven times (0.004 to 0.036 s): set on every 0.001 s")
    # times that are even but for their last digit stay as they are
    rounded = np.round(np.arange(3001) / 300, 3)
    even = read(files.volume_1(tmp_path / "even.raw", {"UP": (rounded, shaking(3001, peak=1.0))}))
    assert (even.n, even.history) == (3001, ())
    assert even.dt == pytest.approx(1 / 300, rel=1e-6)


def test_what_is_not_an_acceleration_is_refused(tmp_path):
    for path, words in (
        (files.esm(tmp_path / "v.asc", shaking(), DATA_TYPE="VELOCITY"), "holds velocity"),
        (files.esm(tmp_path / "u.asc", shaking(), UNITS="counts"), "its samples are in 'counts'"),
        (files.smc(tmp_path / "v.smc", shaking(), kind="3 VELOCITY"), "holds 3 velocity"),
        (files.cosmos(tmp_path / "v.v2c", NAMED, kind="displacement"), "holds displacement, velocity"),
        (files.cosmos(tmp_path / "c.v1c", NAMED, unit="counts(50)"), "its samples are in 'counts'"),
    ):
        with pytest.raises(FileError, match=words):
            read(path)


def test_a_suffix_whose_content_is_something_else(tmp_path):
    path = tmp_path / "record.EW"
    path.write_text("0.1\n0.2\n")
    with pytest.raises(
        FileError, match=r"is not a file of K-NET, as its suffix says: it begins with '0\.1' and must have 'Origin"
    ):
        read(path)
    assert read(files.csmip_v2(tmp_path / "other.EW", {"Up": shaking()})).n == 41  # the content decides


def test_line_ends_of_any_kind(tmp_path):
    for end in (b"\r\n", b"\r\r\n", b"\r"):
        path, expected, _ = of_smc(tmp_path / "record.smc")
        path.write_bytes(path.read_bytes().replace(b"\n", end))
        assert near(read(path), expected["133"])


def test_files_that_people_brought(first_day_cases):
    """Headers as K-NET and ESM write them; the peak is that of the header, by hand."""
    assert read(first_day_cases / "knet.EW").pga == pytest.approx(3.44275, rel=2e-6)
    assert read(first_day_cases / "esm.ASC").pga == pytest.approx(3.43654436, rel=1e-8)
