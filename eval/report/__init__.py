"""How results are shown: drawings (matplotlib, also for notebooks), tables in the terminal, and HTML files."""
