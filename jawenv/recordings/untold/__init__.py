"""Errors that nobody told the filter of, learnt at the end of a recording: a wrench, a curved law, a temperature."""
