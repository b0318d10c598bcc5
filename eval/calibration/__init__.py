"""``python -m eval calibrate``: whether filters are honest, that is, whether the truth lies where they claim."""
