"""Comparison of two result files, or of two output folders of the programs: files → runs (pairs, differences) → report."""
