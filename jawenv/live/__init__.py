"""A jaw that a person drives by hand, with the environment and its filter behind it, and the page that shows it."""
