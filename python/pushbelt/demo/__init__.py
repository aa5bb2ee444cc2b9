"""Demonstration of the pushbelt FMU: simulations of published data (`simulate`), events and checks of them, and a report."""
