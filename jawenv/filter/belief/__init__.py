"""The belief about the muscles: tensions as sums of fixed functions, and what their information says of F_o and b."""
