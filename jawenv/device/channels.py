"""The four channels in which a device is told where to move a jaw, as fractions of this patient's comfort."""

CHANNELS = ("opening", "side", "fore_aft", "roll")
N_CHANNELS = len(CHANNELS)
OPENING, SIDE, FORE_AFT, ROLL = range(N_CHANNELS)
LOWEST = (0.0, -1.0, -1.0, -1.0)
HIGHEST = 1.0
ROLL_FULL_SCALE_RAD = 0.07
# 1/s: rate at which the device moves a target, at most. On a typical patient 23 mm/s of opening and 18 mm/s of side.
FASTEST_TARGET = (0.9, 3.0, 1.5, 3.0)
