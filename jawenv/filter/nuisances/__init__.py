"""What is known only within an sd beside the muscles: what each such number changes, and its corrections."""
