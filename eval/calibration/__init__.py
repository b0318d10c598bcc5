"""``python -m eval calibrate``: whether error bars are right: the truth lies where filters claim."""
