"""A rig.toml that explains itself reads back equal."""

from dataclasses import fields, replace
from datetime import date
from pathlib import Path

from dampyr.records.checks.certificates import Certificates, RelativeCertificate
from dampyr.rig.settings import RigSettings, load_settings
from dampyr.rig.settings_file import write_settings


def test_it_reads_back_equal_to_the_last_bit(tmp_path: Path) -> None:
    base = RigSettings()
    odd = replace(
        base,
        name='a "table" of Curitiba, 25 µm \\ no. 2',
        actuator=replace(base.actuator, lag=0.1 + 0.2, droop=1.0 / 3.0e5),
        supply=replace(base.supply, enable_line=False),
        wires=replace(base.wires, serial="COM3", temperature="ai1"),
    )
    cell = RelativeCertificate(date(2026, 3, 1), date(2027, 3, 1), 'no. "7"', "the laboratory", 2.0, 1.0 / 3.0e3)
    certified = replace(base, certificates=Certificates(cell))
    for rig in (base, odd, certified):
        assert load_settings(write_settings(rig, tmp_path / "rig.toml")) == rig


def test_every_value_stands_there_with_its_unit_and_origin(tmp_path: Path) -> None:
    rig = RigSettings()
    lines = write_settings(rig, tmp_path / "rig.toml").read_text("utf-8").splitlines()
    for part in fields(rig):
        if part.name == "name":
            continue
        assert any(line.startswith(f"[{part.name}]") for line in lines)
        for value in fields(getattr(rig, part.name)):
            assert any(line.removeprefix("# ").startswith(f"{value.name} = ") for line in lines)
    (speed,) = [line for line in lines if line.startswith("free_speed")]
    assert speed.startswith("free_speed = 0.078  # m/s; measured: 78 mm/s at full PWM")
