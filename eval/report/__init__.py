"""How results are shown: figures (matplotlib, also for notebooks), tables in the terminal, words, and HTML files."""
