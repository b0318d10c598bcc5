"""What studies the loop and is not in it: recordings, reference filters, the methods of Young (2016), analysis."""
