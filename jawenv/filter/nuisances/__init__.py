"""Nuisances, numbers beside the muscles that are known only within an sd: effects and corrections."""
