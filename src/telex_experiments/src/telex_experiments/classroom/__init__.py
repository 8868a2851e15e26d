"""What trying the page of a class takes: stand-ins for stations, a live one, and the page."""
