"""The sections of the report. Each module solves its points with the FMU and evaluates the checks."""
