"""The dissertation's two methods for the viscous Dahl model."""
