"""Written by cargo fmu describe."""

__version__ = "0.1.0"
