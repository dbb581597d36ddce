"""The bench's own figures: alerts, budgets, fidelity, sensitivity."""
