"""What is kept of a long piece of work: named by a digest of what decides it, whole or not at all, and found again."""
