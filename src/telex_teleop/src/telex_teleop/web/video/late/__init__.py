"""Pictures that come late: which of them are taken, and when they have passed the line."""
