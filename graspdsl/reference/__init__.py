"""What there is to write with, told from the tables, models and grammar themselves: for pages and for the terminal."""
