"""Many recordings, each diagnosed by itself: pages, an index, and a trend of every machine."""
