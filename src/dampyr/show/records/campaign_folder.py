"""What a row of a campaign's table shows."""

from __future__ import annotations

from dampyr.records.files.campaign_folder import CampaignRow
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_row(row: CampaignRow) -> Description:
    """Its place in a table, its label, voltage, role, file and published parameters."""
    printed = ", ".join(f"{name} {value:.4g}" for name, value in row.published.items())
    rows = [
        ("table", f"{row.label.table or 'none'}" + (f", row {row.label.row}" if row.label.row else "")),
        ("label", f"{1e3 * row.label.peak_to_peak_m:.4g} mm peak to peak, {row.label.frequency_hz:.4g} Hz"),
        ("voltage", f"{row.voltage:.4g} V"),
        ("role", row.role),
        ("file", "not in the folder" if row.file is None else row.file.name),
        ("published", f"{printed} (SI)" if printed else ""),
    ]
    return Description(f"CampaignRow {row.file_name!r}", [shown for shown in rows if shown[1]])
