"""An Arduino Uno with dampyr's firmware, or any controller that speaks its protocol on a serial wire."""

ROLE = "drive"
