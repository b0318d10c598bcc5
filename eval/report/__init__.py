"""Results on show: drawings (matplotlib, also for notebooks), tables in the terminal, and HTML files."""
