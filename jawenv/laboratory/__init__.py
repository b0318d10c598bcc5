"""Studies of the loop from outside: recordings, reference filters, the methods of Young (2016), analysis."""
