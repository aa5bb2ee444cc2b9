"""The sections of the report: each module solves its points of the FMU and judges them."""
