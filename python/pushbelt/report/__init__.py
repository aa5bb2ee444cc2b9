"""Common parts of the reports: pages from templates, figures, the animated belt, colours; and processes with a progress bar."""
