"""A frozen benchmark: named tasks, and one score per task and agent."""
