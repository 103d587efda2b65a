"""The player: a mission in the browser, live, replayed, or as one file to share."""
