"""The nodes: a recorder and a player."""
