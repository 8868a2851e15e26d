"""The judge: a fold over what was recorded, and the sheet that comes of it."""
