"""Comparison of two runs: `python -m pushbelt.compare A B`, for two result files or two output folders of the programs.

Data flow: files → runs (pairs, differences) → figures → report.
"""
