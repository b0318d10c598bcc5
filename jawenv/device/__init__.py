"""The device at the jaw: motors and linkage, load cell and encoders, comfort limits and governor."""

from jawenv.device.device import MOTOR_NAMES, Device

__all__ = ["MOTOR_NAMES", "Device"]
