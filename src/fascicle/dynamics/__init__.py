"""The bundle in time: chambers that fill, a load that moves, and where every joule went."""
