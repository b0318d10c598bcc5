"""A frozen benchmark: named tasks, one score per task and agent, and submissions that anyone can check again."""
