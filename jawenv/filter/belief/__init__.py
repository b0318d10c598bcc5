"""The belief: its record with the settings' beside it, and what information says of F_o and b."""
