"""Workers that compute the tiles of a study, which the one writer of its store takes from them; how large tiles are."""
