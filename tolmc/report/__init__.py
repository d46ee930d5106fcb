"""The report of a run: one HTML file that needs nothing else, the same as Markdown, its tables as CSV files."""
