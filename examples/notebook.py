"""Runs examples/notebook.ipynb and keeps its outputs: `PYTHONPATH=python target/venv/bin/python examples/notebook.py` after `cargo fmu demo`."""

from pathlib import Path

import nbformat
from nbclient import NotebookClient

PATH = Path(__file__).with_suffix(".ipynb")


def run(folder: Path) -> nbformat.NotebookNode:
    """The notebook with its outputs, without times and versions."""
    book = nbformat.read(PATH, as_version=4)
    NotebookClient(book, timeout=600, record_timing=False, resources={"metadata": {"path": str(folder)}}).execute()
    book.metadata.language_info = {"name": "python"}
    return book


if __name__ == "__main__":
    nbformat.write(run(PATH.parents[1]), PATH)
    print(PATH)
