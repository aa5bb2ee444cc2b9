"""Two runs over each other: `python -m pushbelt.compare A B`, two result files or two folders that the programs wrote.

Data flows one way: files → runs (pairs, differences) → figures → report.
"""
